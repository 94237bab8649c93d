"""Diagnoses of measured records, as they are published: `make diagnosis-reports`."""

from __future__ import annotations

import re
import sys
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from ...models import data_file
from ...models.folders import write_atomic
from ...models.model import resolve
from ..numbers import fixed, number

if TYPE_CHECKING:
    from ...datasets.record import Record
    from ...diagnosis.result import Diagnosis
    from .rivals import YawRateSkill

FOLDER = Path("reports/diagnosis")
MARIN = "kvlcc2-marin"
EVERY = {"kvlcc2-hsva": 5, MARIN: 5}
"""Which samples of a set are kept: the motion of a 7 m model needs no more than 4 Hz; the records have 20 Hz."""


def as_public_loaders_name_them(record: Record) -> Record:
    """An HSVA record under the column names of public loaders: earth-fixed velocities as surge and sway, the yaw rate
    as roll rate, and the roll angle as yaw rate."""
    psi, u, v = (record.column(name) for name in ("heading_rad", "surge_m_s", "sway_m_s"))
    channels: dict[str, Any] = {
        "surge_m_s": u * np.cos(psi) - v * np.sin(psi),
        "sway_m_s": u * np.sin(psi) + v * np.cos(psi),
        "roll_rate_rad_s": record.column("yaw_rate_rad_s"),
        "yaw_rate_rad_s": record.column("roll_rad"),
        "roll_rad": None,
    }
    return record.with_channels(**channels)


@dataclass(frozen=True)
class PublishedDiagnosis:
    """One published diagnosis, as `published.yaml` states it."""

    title: str
    note: str
    dataset: str
    train: Sequence[str] = ()
    held_out: Sequence[str] = ()
    elsewhere: Sequence[str] = ()
    model: str = ""
    options: Mapping[str, Any] = field(default_factory=dict)
    public_columns: bool = False

    def records(self) -> tuple[list[Record], list[Record]]:
        """Training and held-out records."""
        from ...datasets.io import read_record
        from ...datasets.measured import data_dir, load, stems

        folder = data_dir() / self.dataset
        if not self.train:
            train, held_out = (
                [read_record(path) for path in sorted(folder.glob(f"{side}-*.csv"))] for side in ("train", "heldout")
            )
            return train, held_out
        away = [(MARIN, stem) for stem in self.elsewhere]
        train = stems(self.dataset) if self.train == "all" else self.train
        sides = [(self.dataset, stem) for stem in train], [*((self.dataset, s) for s in self.held_out), *away]
        train, held_out = ([load(*run).thinned(EVERY.get(run[0], 1)) for run in side] for side in sides)
        return train, held_out


PUBLISHED = {
    name: PublishedDiagnosis(**facts)
    for name, facts in data_file.load(Path(__file__).with_name("published.yaml")).items()
}


def diagnosed(report: PublishedDiagnosis) -> Diagnosis:
    """The diagnosis of a report; BadInput where the measured set is missing on this machine."""
    from ...diagnosis.diagnose import diagnose
    from ...diagnosis.gain.runs import with_errors_ahead
    from ...diagnosis.options import Options

    model = resolve(report.model)
    train, held_out = (
        [as_public_loaders_name_them(record) if report.public_columns else record for record in turned]
        for turned in ([one.turned(model.positive_rudder) for one in side] for side in report.records())
    )
    given = ((name, tuple(value) if isinstance(value, list) else value) for name, value in report.options.items())
    options: dict[str, Any] = dict(given)
    return with_errors_ahead(diagnose(model, train, held_out, Options(**options)))


RIVALS = """## Craft without a model, beside two models that anyone would try first

R² of the yaw rate along the held-out records: windows of four times the craft's own time, ten of which begin within
one, from the smoothed yaw rate at their start. *Nomoto*: first order, with a neutral angle and a delay. *ARX*: a linear
difference equation. Both are fitted to the yaw rate of the training records, which choose delay, orders and time
constant as well (`helmbench.reporting.diagnosis.rivals`). *Against the better*: what the craft's model has more than
the better of the two."""


def write_reports(folder: Path = FOLDER, beginning: str = "") -> None:
    """Write the reports whose names begin so, and a list of all; others keep their line and their row in it."""
    from ...diagnosis.craft.build import build
    from ..craft import page as craft_page
    from ..craft import told_in_a_line
    from ..media import write_markdown
    from .page import page
    from .rivals import compared
    from .words import verdict

    kept, rows = _kept(folder / "README.md")
    for name, report in PUBLISHED.items():
        if not name.startswith(beginning):
            continue
        if report.model:
            found = diagnosed(report)
            shown, said = page(replace(found, wall_s=0.0, cpu_s=0.0)), verdict(found)
        else:
            records = report.records()
            built = build(*records)
            shown, said = craft_page(built), told_in_a_line(built)
            rows[name] = _row(name, report, compared(built.model, *records))
        write_markdown(shown, folder, name, report.title, report.note)
        kept[name] = f"- [{report.title}]({name}.md): {said}"
        print(kept[name], rows.get(name, ""))
    head = ["# Diagnoses of measured records", "Generated by `make diagnosis-reports`; not edited by hand."]
    lines = [kept[name] for name in PUBLISHED if name in kept]
    table = [*TABLE, *(rows[name] for name in PUBLISHED if name in rows)]
    text = "\n\n".join([*head, "\n".join(lines), RIVALS, "\n".join(table)])
    write_atomic(folder / "README.md", (text + "\n").encode())


TABLE = (
    "| craft | window, s | windows | craft's model | Nomoto | ARX | against the better |",
    "| --- | ---: | ---: | ---: | ---: | ---: | ---: |",
)


def _row(name: str, report: PublishedDiagnosis, of: YawRateSkill) -> str:
    """The row of a craft."""
    scores = " | ".join(fixed(value, 3) for value in (of.craft, of.nomoto, of.arx))
    more = f"{of.craft - max(of.nomoto, of.arx):+.3f}"
    return f"| [{report.title}]({name}.md) | {number(of.window_s)} | {of.windows} | {scores} | {more} |"


def _kept(readme: Path) -> tuple[dict[str, str], dict[str, str]]:
    """Name of a report -> its line in the list, and its row in the table, as far as there are any."""
    text = readme.read_text("utf-8") if readme.is_file() else ""
    lines, rows = (
        {match[1]: match.string for line in text.splitlines() if (match := re.match(pattern, line))}
        for pattern in (r"- \[.*?\]\(([\w-]+)\.md\): ", r"\| \[.*?\]\(([\w-]+)\.md\) \|")
    )
    return lines, rows


if __name__ == "__main__":
    write_reports(Path(sys.argv[1]) if len(sys.argv) > 1 else FOLDER, sys.argv[2] if len(sys.argv) > 2 else "")
