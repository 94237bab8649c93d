"""Diagnoses of measured records, as they are published: `make diagnosis-reports`."""

from __future__ import annotations

import re
import sys
from collections.abc import Callable
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from ...datasets.measured import stems
from ...models.folders import write_atomic
from ...models.model import resolve
from ..numbers import fixed, number

if TYPE_CHECKING:
    from ...datasets.record import Record
    from ...diagnosis.result import Diagnosis
    from .rivals import YawRateSkill

FOLDER = Path("reports/diagnosis")
HSVA, MARIN, ESSO_OSAKA, BLUEBOAT = "kvlcc2-hsva", "kvlcc2-marin", "esso-osaka", "blueboat"
EVERY = {HSVA: 5, MARIN: 5}
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
    """One published diagnosis: runs of a measured set, and the base model with its options; of a craft without a model
    runs of a set, or all of a folder beside the measured sets.

    prepare : what is done to the records first.
    elsewhere : held-out runs of the set MARIN, beside those of the set.
    """

    title: str
    note: str
    dataset: str
    train: tuple[str, ...] = ()
    held_out: tuple[str, ...] = ()
    model: str = ""
    options: dict[str, Any] = field(default_factory=dict)
    prepare: Callable[[Record], Record] | None = None
    elsewhere: tuple[str, ...] = ()

    def records(self) -> tuple[list[Record], list[Record]]:
        """Training and held-out records; a folder has `train-*.csv` and `heldout-*.csv`."""
        from ...datasets.io import read_record
        from ...datasets.measured import data_dir, load

        folder = data_dir() / self.dataset
        if not self.train:
            train, held_out = (
                [read_record(path) for path in sorted(folder.glob(f"{side}-*.csv"))] for side in ("train", "heldout")
            )
            return train, held_out
        away = [(MARIN, stem) for stem in self.elsewhere]
        sides = [(self.dataset, stem) for stem in self.train], [*((self.dataset, s) for s in self.held_out), *away]
        train, held_out = ([load(*run).thinned(EVERY.get(run[0], 1)) for run in side] for side in sides)
        return train, held_out


APART = ("zigzag_31-Jul-2020_13_57_45", "zigzag_31-Jul-2020_14_10_05")
"""Zigzags of the Esso Osaka model that the vessel's numbers do not come from."""


REPORTS = {
    "kvlcc2-simulation": PublishedDiagnosis(
        "The published KVLCC2 simulation against HSVA's runs, and its transfer to MARIN's",
        "The simulation of Yasukawa and Yoshimura (2015), trained on ten runs of one laboratory and scored, nothing "
        "refitted, on the zigzags of another. The vessel file pairs the open-water curve of one propeller with the "
        "diameter of another, so that its thrust is too small.",
        HSVA,
        tuple(stems(HSVA)),
        (),
        "kvlcc2-l7",
        {"base_parameters": "file"},
        elsewhere=("zz_10", "zz_-10", "zz_20", "zz_-20"),
    ),
    "hsva-public-columns": PublishedDiagnosis(
        "HSVA zigzags under the column names of public loaders",
        "The columns that public loaders call surge, sway, roll rate and yaw rate, used as they are named.",
        HSVA,
        ("Z_15_05", "Z_20_05"),
        ("Z_25_05",),
        "kvlcc2-l7",
        {"base_parameters": "file"},
        as_public_loaders_name_them,
    ),
    "hsva-nomoto": PublishedDiagnosis(
        "HSVA 15/5 zigzag with a first-order Nomoto model",
        "What a first-order response model does not describe of a free-running tanker model.",
        HSVA,
        ("Z_15_05",),
        ("Z_25_05", "Z_10_10_P", "Z_10_10_S", "Z_20_10_S"),
        "nomoto-1-cubic",
        {"base_parameters": "identify"},
    ),
    "hsva-nomoto-runs": PublishedDiagnosis(
        "HSVA zigzags with a second-order Nomoto model",
        "Five runs for training; the terms that the model lacks are named by free runs of runs that were left out.",
        HSVA,
        ("Z_10_05", "Z_10_10_P", "Z_15_05", "Z_20_05", "Z_25_05"),
        ("Z_10_10_S", "Z_20_10_S", "Z_35_05"),
        "nomoto-2",
        {"base_parameters": "identify"},
    ),
    "hsva-small-angles": PublishedDiagnosis(
        "HSVA 5/1 zigzag, heading and rudder alone",
        "The neutral rudder angle, from the smallest zigzag and the fewest channels.",
        HSVA,
        ("Z_05_01",),
        ("Z_15_01",),
        "nomoto-2",
        {"base_parameters": "identify", "channels": ("heading_rad",)},
    ),
    "marin-simulation": PublishedDiagnosis(
        "The published KVLCC2 simulation against MARIN's runs alone",
        "Turning circles and two zigzags for training, the other zigzags held out. The yaw rates of these records show "
        "an offset that differs from run to run.",
        MARIN,
        ("tc_-35", "tc_35", "zz_-10", "zz_-20"),
        ("zz_10", "zz_20"),
        "kvlcc2-l7",
        {"base_parameters": "file"},
    ),
    "esso-osaka-pond": PublishedDiagnosis(
        "The Esso Osaka model of 3 m in a pond, with measured wind",
        "Five zigzags of a free-running model (Wakita et al. 2022). The numbers of the vessel come from three of them, "
        "which train here as well; the two others took no part in either.",
        ESSO_OSAKA,
        tuple(stem for stem in stems(ESSO_OSAKA) if stem.startswith("zigzag") and stem not in APART),
        APART,
        "esso-osaka-l3",
        {"base_parameters": "file"},
    ),
    "blueboat-nomoto": PublishedDiagnosis(
        "A BlueBoat steered by its two propellers, with a first-order Nomoto model",
        "Logger files of an unmanned surface vessel. What the model takes as rudder is the difference of the two "
        "propellers' commands, whose sides the published columns exchange.",
        BLUEBOAT,
        ("train-0", "train-1"),
        ("train-2", "heldout-0"),
        "nomoto-1-cubic",
        {"base_parameters": "identify"},
    ),
}


def diagnosed(report: PublishedDiagnosis) -> Diagnosis:
    """The diagnosis of a report; BadInput where the measured set is missing on this machine."""
    from ...diagnosis.diagnose import diagnose
    from ...diagnosis.gain.runs import with_errors_ahead
    from ...diagnosis.options import Options

    model = resolve(report.model)
    train, held_out = (
        [report.prepare(record) if report.prepare else record for record in turned]
        for turned in ([one.turned(model.positive_rudder) for one in side] for side in report.records())
    )
    return with_errors_ahead(diagnose(model, train, held_out, Options(**report.options)))


POND = tuple(stem for stem in stems(ESSO_OSAKA) if stem.startswith("zigzag") and stem not in APART)
TURNS_IN_POND = tuple(stem for stem in stems(ESSO_OSAKA) if not stem.startswith("zigzag"))
FOREIGN = "Records that the library does not fetch: the reader's own data folder holds them."
CRAFT = {
    "craft-blueboat": PublishedDiagnosis(
        "A BlueBoat without a model", "Steered by its two propellers, whose sides the published columns exchange.",
        BLUEBOAT, ("train-0", "train-1", "train-2"), ("heldout-0",),
    ),
    "craft-esso-osaka-zigzags": PublishedDiagnosis(
        "The Esso Osaka model of 3 m without a model: zigzags", "Five zigzags in a pond, with measured wind.",
        ESSO_OSAKA, POND, APART,
    ),
    "craft-esso-osaka": PublishedDiagnosis(
        "The Esso Osaka model of 3 m without a model: zigzags, turns and a random run",
        "The random run backs its propeller, which no training run does.",
        ESSO_OSAKA, (*POND, APART[0], TURNS_IN_POND[1]), (APART[1], TURNS_IN_POND[0], TURNS_IN_POND[2]),
    ),
    "craft-hsva": PublishedDiagnosis(
        "HSVA's 7 m KVLCC2 without a model", "Free-running zigzags of a tanker that is unstable on a straight course.",
        HSVA, ("Z_10_05", "Z_10_10_P", "Z_15_05", "Z_20_05", "Z_25_05"), ("Z_10_10_S", "Z_20_10_S", "Z_35_05"),
    ),
    "craft-marin": PublishedDiagnosis(
        "MARIN's KVLCC2 without a model",
        "A turning circle and two zigzags train, those to the other side are held out.",
        MARIN, ("tc_-35", "zz_-10", "zz_-20"), ("tc_35", "zz_10", "zz_20"),
    ),
    "craft-otter": PublishedDiagnosis(
        "An Otter catamaran without a model", f"Two propellers under a course controller, in wind. {FOREIGN}", "otter"
    ),
    "craft-vtec": PublishedDiagnosis(
        "A VTec S-III without a model", f"Two propellers, a pool and a lake. {FOREIGN}", "vtec"
    ),
    "craft-expedition": PublishedDiagnosis(
        "An ocean racing yacht without a model", f"Logged every second in waves, rudder measured. {FOREIGN}",
        "expedition_horta",
    ),
    "craft-expedition-gps": PublishedDiagnosis(
        "The ocean racing yacht over ground, without a model",
        f"The same runs, with speed and course over ground in place of the speed through the water. {FOREIGN}",
        "expedition_horta_gps",
    ),
    "craft-rov": PublishedDiagnosis(
        "A remotely operated vehicle without a model: steps in yaw",
        f"What steers it is the yaw command of its thrusters; no speed is measured. {FOREIGN}", "exjobb-yaw",
    ),
    "craft-rov-loop": PublishedDiagnosis(
        "A remotely operated vehicle without a model: under its own controller",
        f"The command follows the yaw rate, and does not act in the first seconds. {FOREIGN}", "exjobb-loop",
    ),
    "craft-model-yacht": PublishedDiagnosis(
        "A model yacht without a model", f"Sailed by hand, its heading and track seen from outside. {FOREIGN}",
        "madao-april",
    ),
}  # fmt: skip


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
    for name in (name for name in (*REPORTS, *CRAFT) if name.startswith(beginning)):
        if name in REPORTS:
            report, found = REPORTS[name], diagnosed(REPORTS[name])
            shown, said = page(replace(found, wall_s=0.0, cpu_s=0.0)), verdict(found)
        else:
            report = CRAFT[name]
            records = report.records()
            built = build(*records)
            shown, said = craft_page(built), told_in_a_line(built)
            rows[name] = _row(name, report, compared(built.model, *records))
        write_markdown(shown, folder, name, report.title, report.note)
        kept[name] = f"- [{report.title}]({name}.md): {said}"
        print(kept[name], rows.get(name, ""))
    head = ["# Diagnoses of measured records", "Generated by `make diagnosis-reports`; not edited by hand."]
    lines = [kept[name] for name in (*REPORTS, *CRAFT) if name in kept]
    table = [*TABLE, *(rows[name] for name in CRAFT if name in rows)]
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
