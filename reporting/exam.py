"""An exam in words: the texts of its folder, and the tables of its scores."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from functools import partial
from typing import TYPE_CHECKING

from .equations import equations
from .numbers import MISSING, SHORT, percent
from .tables import Column, Table, csv, field, in_markdown, make_table, markdown, numeric

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
README = """# Exam {exam}

{count} worlds: records of ships, and a model of each. In most of them something was changed that the model does not
know. Name it, and say how large it is, where it acts, and how the ship moves in the held-out records.

    exam.json               the worlds, groups of each model's own numbers, SHA-256 of the worlds' files and of the key
    causes.json             the public names of causes, with what their sizes are called and their units
    submission.schema.json  JSON schema of what you hand in
    equations.md            the equations of the models
    WORLD/model.json        the base model: family, parameters with units, constants, steering gear, windage
    WORLD/train-*.csv       training records; beside each a YAML file with the side to which a positive rudder turns
    WORLD/held_out-*.csv    held-out records: their motion ends at `opening_s` of exam.json, their rudder goes on

Records are in SI units and radians, the unit is part of a column's name; empty cells are gaps. `base_numbers` says of
each model whether its numbers are exact or uncertain. The ships are like published ones, with numbers of their own.

## What you hand in

One JSON file, `submission.json`:

    {{"schema_version": 1, "exam": "{exam}", "entrant": "your method",
     "worlds": {{
       "{first}": {{
         "named": [{{"cause": "rudder_offset",
                    "sizes": [{{"parameter": "delta0", "value": 0.01, "low": 0.008, "high": 0.012}}]}}],
         "motion": {{"{held_out}": "{first}-{held_out}.csv"}}}}}}}}

- `named`: what is wrong, the surest first, by the names of causes.json or the groups (`group:...`) of exam.json;
  empty: nothing is. `tied_with`: names that would do as well. `regime`: where it acts, `{{"variable": "rudder",
  "side": "above", "threshold": 0.2}}`.
- `sizes`: in SI units; 90 % interval (`low`, `high`) and `record` may be left out. A cause is named once, and each of
  its sizes stated once a record.
- `motion`: the held-out file with its empty cells filled in. Or `model`: an extended model.json, which is simulated.
- `unexplained`: true where something is wrong that has no name here. A world that is left out says: nothing is wrong.
"""


def folder_texts(manifest: Manifest, models: Mapping[str, Model]) -> dict[str, str]:
    """Texts of an exam's folder: name of the file -> text."""
    first, files = next(iter(manifest.worlds.items()))
    readme = README.format(exam=manifest.exam, count=len(manifest.worlds), first=first, held_out=files.held_out[0])
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


MEANING = """- **points**, by which entrants are compared: 1 where an answer is right alone, -1 where it names what is
  false and nothing right, else 0; mean over the worlds. Who never names anything has the share of worlds without a
  change.
- **alone right**: what was changed is named and nothing else, or nothing where nothing was changed.
  Beside a base model of which all numbers are off, names of its own numbers are right as well, and no false alarm.
- **right names**: right names over all names that were stated or had to be, ties included; mean over the worlds in
  which something was changed. **false alarms**: share of the worlds without a change in which something is named.
- **size off by**: relative error of the sizes of rightly named causes, 100 % where none is stated; median over effects,
  each of which counts once. **in interval**: share of the stated intervals that hold the true size; one that is wider
  than ten true sizes, or half a turn, holds none. **interval score**: width of the interval over the true size, and 20
  times what it misses it by.
- **regime**: F1 of the samples in which the change is said to act, rescaled so that "everywhere" has 0.
- **predicted**: share of the worlds with predicted motion. **error / base**, **error / best**: error of the predicted
  motion of held-out records over that of the base model and over that of the true ship, which starts from the true
  state and knows no gusts; geometric means over channels and worlds. No prediction counts as the base model's."""


def text(scores: Sequence[EntrantScore], rows: Sequence[WorldScore]) -> str:
    """The scores as Markdown."""
    tables = (overall(scores), by_kind(scores), worlds(rows))
    parts = [f"## {table.title}\n\n{markdown(table)}" for table in tables]
    return "\n".join(["# Scores of the exam", "", MEANING, "", "\n\n".join(parts).rstrip(), ""])


def scores_csv(scores: Sequence[EntrantScore]) -> str:
    """Scores of every entrant over all worlds and by kind as CSV."""
    return csv(make_table([KIND, *SCORES], list(scores)))
