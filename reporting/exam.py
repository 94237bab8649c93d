"""An exam in words: the texts of its folder, and the tables of its scores."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from functools import partial
from typing import TYPE_CHECKING

from .equations import equations
from .numbers import MISSING, SHORT, percent
from .tables import Column, Table, console, csv, field, in_markdown, make_table, markdown, numeric
from .templating import FOLDER

if TYPE_CHECKING:
    from ..bench.exam.exam_file import Manifest
    from ..bench.exam.scores import EntrantScore, WorldScore
    from ..models.model import Model

KIND = field("kind", "kind of world")
RIGHT_NAMES, REGIME = numeric("right names", "right_share", percent), numeric("regime", "regime", SHORT)
MOTION = (numeric("error / base", "to_base"), numeric("error / best", "to_best"))
SCORES = (
    Column("entrant", lambda one: one.entrant, markdown=lambda one: in_markdown(one.entrant)),
    numeric("worlds", "worlds", str),
    numeric("points", "points", "{:.2f}".format),
    numeric("alone right", "alone", percent),
    RIGHT_NAMES,
    numeric("false alarms", lambda one: one.false_alarms, percent),
    numeric("size off by", lambda one: one.wrong_size, partial(percent, decimals=1)),
    numeric("sizes", "sizes", str),
    numeric("in interval", "coverage", percent),
    numeric("interval score", "interval"),
    REGIME,
    numeric("predicted", "predicted", percent),
    *MOTION,
)


def folder_texts(manifest: Manifest, models: Mapping[str, Model]) -> dict[str, str]:
    """Texts of an exam's folder: name of the file -> text."""
    first, files = next(iter(manifest.worlds.items()))
    template = (FOLDER / "exam_folder.md").read_text("utf-8")
    readme = template.format(exam=manifest.exam, count=len(manifest.worlds), first=first, held_out=files.held_out[0])
    return {"README.md": readme, "equations.md": equations_text(models)}


def equations_text(models: Mapping[str, Model]) -> str:
    """The equations of the families of models, in LaTeX, as their definitions have them."""
    families: dict[str, Model] = {}
    for model in models.values():
        families.setdefault(model.family, model.blanked())
    lines = [
        "# Equations",
        "",
        "States: surge u and sway v, m/s; yaw rate r, rad/s; heading psi, rad; positions x, y, m.",
    ]
    for name, model in sorted(families.items()):
        shown = equations(model, model)
        lines += ["", f"## {name}", ""]
        for line in (*shown.dynamics, *shown.helpers):
            lines += ["$$", line.latex, "$$", ""]
    return "\n".join(lines).rstrip() + "\n"


def overall(scores: Sequence[EntrantScore]) -> Table:
    """One row an entrant, over all worlds."""
    from ..bench.exam.scores import ALL

    return make_table(SCORES, [one for one in scores if one.kind == ALL], "All worlds")


def by_kind(scores: Sequence[EntrantScore]) -> Table:
    """One row an entrant and kind of world."""
    from ..bench.exam.scores import ALL

    rows = sorted((one for one in scores if one.kind != ALL), key=lambda one: one.kind)
    return make_table([KIND, *SCORES], rows, "By kind of world")


def worlds(rows: Sequence[WorldScore]) -> Table:
    """One row an answer."""
    columns = [
        field("world"),
        KIND,
        field("entrant"),
        field("outcome"),
        Column("named", lambda row: row.named or MISSING),
        numeric("points", "points", str),
        RIGHT_NAMES,
        REGIME,
        *MOTION,
    ]
    return make_table(columns, sorted(rows, key=lambda row: (row.world, row.entrant)), "Answers")


def page(scores: Sequence[EntrantScore], rows: Sequence[WorldScore]) -> str:
    """The scores as Markdown, with what they mean."""
    parts = [f"## {table.title}\n\n{markdown(table)}" for table in (overall(scores), by_kind(scores), worlds(rows))]
    return (FOLDER / "exam_scores.md").read_text("utf-8") + "\n\n".join(parts).rstrip() + "\n"


def summary(scores: Sequence[EntrantScore], rows: Sequence[WorldScore]) -> str:
    """The scores as plain text."""
    tables = (overall(scores), by_kind(scores), worlds(rows))
    return "\n\n".join(f"{table.title}\n{console(table, fit=True)}" for table in tables)


def scores_csv(scores: Sequence[EntrantScore]) -> str:
    """Scores of every entrant over all worlds and by kind as CSV."""
    return csv(make_table([KIND, *SCORES], list(scores)))
