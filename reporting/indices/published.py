"""How well models from indices predict other manoeuvres, of published and measured ships: `make indices-report`.

From turns with 35 degrees and 10/10 zigzags, to both sides, a model is made; it then sails turns with 20 degrees and
20/20 zigzags.  Indices are means of both sides.
"""

from __future__ import annotations

import math
import sys
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path

import numpy as np

from ...datasets import measured
from ...datasets.generator import record_run
from ...datasets.grammar import DEGREE
from ...datasets.indices import TURNING, execute_times, initial_turning, overshoots, turning_indices
from ...datasets.manoeuvres import parse_manoeuvre
from ...datasets.record import Record
from ...estimation.indices.fit import fit
from ...estimation.indices.given import read_indices
from ...estimation.indices.result import ModelFromIndices
from ...models.folders import make_folder, write_atomic
from ...models.model import Model, resolve
from ..numbers import number, percent
from ..tables import Column, make_table, markdown
from .page import named_key, statement

VESSELS = ("mariner", "s175", "kvlcc2-l7", "esso-osaka-l3")
GIVEN, LEFT_OUT = ("turn:35", "zigzag:10/10"), ("turn:20", "zigzag:20/20")
LENGTHS, STEPS = 60.0, 100
"""Duration of a simulated manoeuvre and samples, in the time L/U."""
STEADY_TURN = math.radians(600.0)
"""Heading change at which a measured turn is cut: the rudder goes back behind it."""
MARIN = "kvlcc2-marin"
MARIN_LENGTH_M, MARIN_RUDDER_DEG_S = 7.0, 15.8
MARIN_RUNS = {
    "turn:35": ("tc_35", "tc_-35"),
    "zigzag:10/10": ("zz_10", "zz_-10"),
    "zigzag:20/20": ("zz_20", "zz_-20"),
}
FASTEST_DEG_S = 30.0
"""Rudder rate of a ship whose file states none."""
Values = Mapping[str, float]


@dataclass(frozen=True)
class TriedShip:
    """A ship: what she is, length, m, approach speed, m/s, rudder, and what gives her record of a manoeuvre's sides."""

    title: str
    length_m: float
    speed_m_s: float
    rudder_rate_deg_s: float
    rudder_max_deg: float
    records: Callable[[str], Sequence[Record]]
    manoeuvres: tuple[str, ...]


def published_ship(name: str) -> TriedShip:
    """A vessel of the package, which sails by herself; at the speed that she keeps on a straight course."""
    model = replace(resolve(name), suite={})
    clock = model.particulars["L"] / model.speed_m_s
    steady = record_run(model, parse_manoeuvre("straight"), duration_s=20.0 * LENGTHS * clock, dt_s=clock)
    model = replace(model, speed_m_s=float(steady.column("surge_m_s")[-1]))
    rate = model.rudder.rate_rad_s / DEGREE
    return TriedShip(
        f"{model.title}, simulated",
        model.particulars["L"],
        model.speed_m_s,
        rate if math.isfinite(rate) else FASTEST_DEG_S,
        model.rudder.max_rad / DEGREE,
        partial(sailed, model),
        (*GIVEN, *LEFT_OUT),
    )


def sailed(model: Model, text: str) -> list[Record]:
    """A manoeuvre to both sides."""
    clock = model.particulars["L"] / model.speed_m_s
    both = (parse_manoeuvre(text + side) for side in ("", ":port"))
    return [record_run(model, one, duration_s=LENGTHS * clock, dt_s=clock / STEPS) for one in both]


def measured_ship() -> TriedShip:
    """MARIN's free-running model of KVLCC2."""
    first = measured.load(MARIN, MARIN_RUNS["turn:35"][0])
    speeds = np.hypot(first.column("surge_m_s"), first.column("sway_m_s"))
    speed = float(np.mean(speeds[: round(1.0 / first.dt)]))
    return TriedShip(
        "KVLCC2 tanker, 7 m model, measured by MARIN",
        MARIN_LENGTH_M,
        speed,
        MARIN_RUDDER_DEG_S,
        35.0,
        lambda text: [cut(measured.load(MARIN, stem)) for stem in MARIN_RUNS[text]],
        tuple(MARIN_RUNS),
    )


def cut(record: Record) -> Record:
    """A record up to where the heading has changed by `STEADY_TURN`."""
    heading = record.heading_unwrapped()
    beyond = np.flatnonzero(np.abs(heading - heading[0]) > STEADY_TURN)
    return record.slice(0, int(beyond[0])) if beyond.size else record


def indices_of(records: Sequence[Record], text: str, ship: TriedShip) -> dict[str, float]:
    """Indices as a file has them, the means of both sides."""
    sides = [_turn(one, ship) if text.startswith("turn") else _zigzag(one, text, ship) for one in records]
    return {key: float(np.mean([side[key] for side in sides])) for key in sides[0]}


def _turn(record: Record, ship: TriedShip) -> dict[str, float]:
    found = turning_indices(record)
    distances = {f"{name}_lengths": found[name] / ship.length_m for name in TURNING}
    return distances | {"speed_ratio": found["steady_speed"] / ship.speed_m_s}


def _zigzag(record: Record, text: str, ship: TriedShip) -> dict[str, float]:
    first, second = (angle / DEGREE for angle in overshoots(record)[:2])
    found = {"first_overshoot_deg": first, "second_overshoot_deg": second}
    if text != GIVEN[1]:
        return found
    return found | {"initial_turning_lengths": initial_turning(record, float(execute_times(record)[0])) / ship.length_m}


@dataclass(frozen=True)
class TriedIndex:
    """An index of a ship, her own and of the model."""

    manoeuvre: str
    key: str
    own: float
    model: float

    @property
    def error(self) -> float:
        """Relative error of the model."""
        return self.model / self.own - 1.0


def compared(ship: TriedShip) -> tuple[ModelFromIndices, list[TriedIndex]]:
    """The model from the given manoeuvres, and indices of all manoeuvres beside those of the ship."""
    own = {text: indices_of(ship.records(text), text, ship) for text in ship.manoeuvres}
    content = {
        "name": "model",
        "length_m": ship.length_m,
        "speed_m_s": ship.speed_m_s,
        "rudder_rate_deg_s": ship.rudder_rate_deg_s,
        "rudder_max_deg": ship.rudder_max_deg,
        "indices": [{"manoeuvre": text, **own[text]} for text in GIVEN],
    }
    found = fit(read_indices(content))
    of_model = {text: indices_of(sailed(found.model, text), text, ship) for text in ship.manoeuvres}
    return found, [TriedIndex(text, key, own[text][key], of_model[text][key]) for text in own for key in own[text]]


def page(ships: Sequence[TriedShip]) -> str:
    """The report."""
    lines = [
        "# Models from manoeuvring indices, on published and measured ships",
        "",
        "Generated by `make indices-report`; not edited by hand.",
        "",
        f"Given were the indices of {' and '.join(GIVEN)}, the means of both sides, with the accuracies that",
        "`helmbench from-indices` assumes. The other manoeuvres are left out: the model has not seen them.",
    ]
    every: list[TriedIndex] = []
    for ship in ships:
        found, rows = compared(ship)
        every += rows
        lines += ["", f"## {ship.title}", "", *(f"- {line}" for line in statement(found)[1:]), ""]
        lines += [markdown(_table(rows)), "", *_held(found, rows)]
    return "\n".join([*lines, "", "## Root mean square errors over these ships", "", markdown(_summary(every)), ""])


def _held(result: ModelFromIndices, rows: Sequence[TriedIndex]) -> Iterator[str]:
    """Whether the intervals of predicted indices hold those of the ship."""
    own = {(row.manoeuvre, row.key): row.own for row in rows}
    for index in result.indices:
        true = own.get((index.manoeuvre, index.key))
        if index.given is None and true is not None and index.low is not None and index.high is not None:
            name, unit = named_key(index.key)
            held = "holds" if index.low <= true <= index.high else "does not hold"
            ends = f"{number(index.low)} to {number(index.high)} {unit}"
            yield f"The 95 % interval of the {name} of {index.manoeuvre}, {ends}, {held} the ship's {number(true)}."


def _table(rows: Sequence[TriedIndex]):
    return make_table(
        (
            Column("manoeuvre", lambda row: row.manoeuvre),
            Column("", lambda row: "given" if row.manoeuvre in GIVEN else "left out"),
            Column("index", lambda row: " ".join(named_key(row.key)).strip()),
            Column("ship", lambda row: number(row.own), lambda row: row.own),
            Column("model", lambda row: number(row.model), lambda row: row.model),
            Column("error", lambda row: percent(row.error), lambda row: row.error),
        ),
        rows,
    )


def _summary(rows: Sequence[TriedIndex]):
    return make_table(
        (
            Column("manoeuvre", lambda row: row[0]),
            Column("", lambda row: "given" if row[0] in GIVEN else "left out"),
            Column("index", lambda row: named_key(row[1])[0]),
            Column("error", lambda row: percent(row[2]), lambda row: row[2]),
        ),
        list(_pooled(rows)),
    )


def _pooled(rows: Sequence[TriedIndex]) -> Iterator[tuple[str, str, float]]:
    for manoeuvre, key in dict.fromkeys((row.manoeuvre, row.key) for row in rows):
        errors = [row.error for row in rows if (row.manoeuvre, row.key) == (manoeuvre, key)]
        yield manoeuvre, key, float(np.sqrt(np.mean(np.square(errors))))


def main(folder: str) -> None:
    """Write README.md into a folder."""
    make_folder(Path(folder))
    ships = [*map(published_ship, VESSELS), measured_ship()]
    write_atomic(Path(folder) / "README.md", page(ships).encode())


if __name__ == "__main__":
    main(sys.argv[1])
