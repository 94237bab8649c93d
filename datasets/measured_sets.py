"""What measured sets state: where they are published, their files and how these are read, from `measured_sets.yaml`."""

from __future__ import annotations

import csv
import io
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, TypeAlias

import numpy as np

from ..models.data_file import load
from .columns import ACCEPTED, CANONICAL
from .geometry import body_velocities
from .record import Record, RecordMeta, Side

Columns: TypeAlias = tuple[np.ndarray, dict[str, np.ndarray]]
"""Time (N,), s, and channels (N,) in SI units and radians."""
OVER_GROUND = ("velocity_north_m_s", "velocity_east_m_s")
FROUDE = {"m": -1.0, "m/s": -0.5, "rad/s": 0.5, "1/s": 0.5, "s": -0.5}
"""Unit -> power of the scale by which the model's values are larger than the ship's."""


@dataclass(frozen=True)
class MeasuredRun:
    """One file of a measured set: its name and SHA-256 as stored, and the manoeuvre that it holds.

    below : folder below the set's address in which it is published.
    published : name of the published file where it is not `file`.
    """

    file: str
    sha256: str
    manoeuvre: str
    below: str = ""
    published: str = ""


@dataclass(frozen=True)
class Dataset:
    """A measured set: public address, folder below `data_dir()`, runs by stem, and the form of its files.

    columns : as `measured_sets.yaml` has them.  step_s : of rows whose time is not read.  repeated_rows : at the begin
    of a file, that are left out.  lengths_m : of the ship whose values a file holds, and of the model.  unwrapped :
    whether the heading is without jumps.  convert : makes the stored file of the published one (None: they are the
    same).  vessel, positive_rudder, notes : as in the metadata of a record; positions are those of midship.  known :
    what is wrong with the records, found from the consistency of their channels.
    """

    url: str
    folder: str
    citation: str
    runs: Mapping[str, MeasuredRun]
    notes: str
    positive_rudder: Side
    columns: Sequence[str]
    vessel: str | None = None
    licence: str = "not stated; not redistributed here"
    known: str = ""
    encoding: str = "utf-8"
    header_lines: int = 0
    repeated_rows: int = 0
    separator: str | None = None
    step_s: float = 0.0
    lengths_m: tuple[float, float] = (1.0, 1.0)
    unwrapped: bool = False
    convert: Callable[[bytes], bytes] | None = None

    def read(self, content: bytes) -> Columns:
        """The columns of one stored file, at the scale of the model."""
        lines = content.decode(self.encoding).splitlines()[self.header_lines :]
        table = np.loadtxt([line for line in lines if line.strip(", ")], delimiter=self.separator)[self.repeated_rows :]
        found = {}
        for column, values in zip(self.columns, table.T, strict=False):
            called, _, divisor = column.partition(" / ")
            if called != "-":
                name, factor = (called, 1.0) if called in OVER_GROUND else ACCEPTED[called]
                own = self._scaled(values * factor, CANONICAL.get(name, "m/s"))
                found[name] = own / float(divisor) if divisor else own
        if self.unwrapped:
            found["heading_rad"] = np.unwrap(found["heading_rad"])
        if set(OVER_GROUND) <= found.keys():
            over_ground = (found.pop(name) for name in OVER_GROUND)
            found["surge_m_s"], found["sway_m_s"] = body_velocities(*over_ground, found["heading_rad"])
        time = found.pop("time_s") if "time_s" in found else self._scaled(np.arange(len(table)) * self.step_s, "s")
        return time, {name: found[name] for name in CANONICAL if name in found}

    def _scaled(self, values: np.ndarray, unit: str) -> np.ndarray:
        """Values (N,) of the ship as those of the model."""
        ship, model = self.lengths_m
        power = FROUDE.get(unit, 0.0)
        factor = ship / model if abs(power) == 1.0 else np.sqrt(ship / model)
        return values if power == 0.0 or factor == 1.0 else values * factor if power > 0.0 else values / factor

    def record(self, content: bytes, stem: str) -> Record:
        """One run, from the content of its stored file."""
        time, channels = self.read(content)
        meta = RecordMeta(
            vessel=self.vessel,
            reference_point="midship",
            source=self.citation,
            licence=self.licence,
            positive_rudder=self.positive_rudder,
            manoeuvre=self.runs[stem].manoeuvre,
            notes=self.notes,
        )
        return Record(time, channels, name=stem, meta=meta)

    def address(self, run: MeasuredRun) -> str:
        """Where the file of a run is published."""
        return "/".join(part for part in (self.url, run.below, run.published or run.file) if part)


FULL_DIFFERENCE_N = 110.5
"""Difference of force between the propellers of the set `blueboat` that stands for a rudder angle of 1 rad."""
MEASURED = ("yaw", "yaw_rate", "surge", "sway", "x_ned", "y_ned")
"""Columns of its published files that are taken over: heading deg, yaw rate rad/s, speeds m/s, positions m."""


def of_blueboat(content: bytes) -> bytes:
    """A published file of the set `blueboat`, columns of its logger, as a table of the columns of the set.

    Raises
    ------
    KeyError, ValueError : the content is not a published file.
    """
    rows = list(csv.DictReader(io.StringIO(content.decode("utf-8"))))
    stamps_ms = np.array([float(row["original_timestamp"]) for row in rows])
    left, right = (np.array([float(row[f"{side}_force"]) for row in rows]) for side in ("left", "right"))
    taken = [np.array([float(row[name]) for row in rows]) for name in MEASURED]
    table = np.column_stack([(stamps_ms - stamps_ms[0]) / 1000.0, (left - right) / FULL_DIFFERENCE_N, *taken])
    lines = [",".join(DATASETS["blueboat"].columns), *(",".join(f"{value:.7g}" for value in row) for row in table)]
    return ("\n".join(lines) + "\n").encode("ascii")


CONVERTERS = {"blueboat": of_blueboat}


def _dataset(facts: dict[str, Any]) -> Dataset:
    file, convert = facts.pop("file"), CONVERTERS.get(facts.pop("convert", ""))
    said = {stem: [part.strip() for part in text.split("|")] for stem, text in facts.pop("runs").items()}
    runs = {
        stem: MeasuredRun(file.format(stem), sha256, "" if manoeuvre == "none" else manoeuvre, *places)
        for stem, (manoeuvre, sha256, *places) in said.items()
    }
    return Dataset(runs=runs, convert=convert, **facts)


DATASETS: dict[str, Dataset] = {
    name: _dataset(facts) for name, facts in load(Path(__file__).with_suffix(".yaml")).items()
}
"""Name -> measured set."""
