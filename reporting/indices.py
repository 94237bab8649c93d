"""What a model from manoeuvring indices says: parameters and indices with intervals; and how well such models predict
other manoeuvres, which `make indices-report` writes."""

from __future__ import annotations

import math
import sys
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from ..datasets import measured
from ..datasets.generator import record_run
from ..datasets.grammar import DEGREE
from ..datasets.indices import TURNING, execute_times, initial_turning, overshoots, turning_indices
from ..datasets.manoeuvres import parse_manoeuvre
from ..datasets.record import Record
from ..estimation.indices.fit import fit
from ..estimation.indices.given import read_indices
from ..estimation.indices.result import ModelFromIndices
from ..models.folders import make_folder, write_atomic
from ..models.model import Model, resolve
from .numbers import number, percent
from .page import FAIR, GOOD, Verdict, items, result_page
from .tables import Column, Table, field, make_table, markdown, numeric

if TYPE_CHECKING:
    from ..estimation.indices.result import ParameterRow
    from .page import Page

CONTRADICTORY = 4.0
"""Accuracies by which an index is missed that no usual ship of another kind explains."""
UNITS = {"deg_s": "deg/s", "deg_min": "deg/min", "m_s": "m/s", "m": "m", "deg": "deg", "kn": "kn"}
UNITS |= {"lengths": "lengths", "cables": "cables", "ratio": ""}
"""End of a key -> unit, longest first."""
TITLES = ("Indices given and of the model", "The model", "What to know", "")


def page(result: ModelFromIndices) -> Page:
    """The page of a model from indices."""
    first, *told = statement(result)
    return result_page(
        f"Model {result.model.id}",
        result.model.title,
        Verdict(FAIR if result.undetermined or result.missed else GOOD, f"{first.partition(': ')[2]}."),
        seen=[make_table(INDICES, result.indices)],
        changed=[make_table(PARAMETERS, result.parameters)],
        remains=[items([f"{line[:1].upper()}{line[1:]}." for line in told])],
        titles=TITLES,
    )


def statement(result: ModelFromIndices) -> list[str]:
    """What the indices determine, what the model cannot give, and what the intervals hold for."""
    given = [row for row in result.indices if row.given is not None]
    lines = [f"{result.model.id}: {result.model.family} from {len(given)} indices"]
    if result.undetermined:
        lines.append(f"not determined by these indices, usual values are taken: {', '.join(result.undetermined)}")
    for row in result.missed:
        name, unit = named_key(row.key)
        values = f"{number(row.predicted)} {unit}".strip() + f" where {number(row.given)} is given"
        lines.append(f"the model does not give the {name} of {row.manoeuvre}: {values}")
    if result.excess > 1.0:
        lines.append(f"intervals are wider by {number(result.excess)}, as the model misses the indices by so much more")
    if any(abs(row.misfit) > CONTRADICTORY for row in result.missed):
        lines.append("the indices contradict each other, or the ship moves unlike this family: check numbers and units")
    lines.append("intervals are for 95 % and for a ship that moves as this family does, alike to both sides")
    return [*lines, "real ships do not quite: docs/how-to/from-indices.md tells by how much predictions were wrong"]


def named_key(key: str) -> tuple[str, str]:
    """Name of an index and its unit, of its key in the file."""
    ending = next((end for end in UNITS if key.endswith(f"_{end}")), "")
    short = key if ending == "ratio" else key.removesuffix(f"_{ending}")
    return short.replace("_", " "), UNITS.get(ending, "")


def _interval(row: ParameterRow) -> str:
    return f"{number(row.interval[0])} to {number(row.interval[1])}" if row.interval else "not determined"


PARAMETERS = (field("name", "parameter"), numeric("value", "value"), Column("95 % interval", _interval))
INDICES = (
    field("manoeuvre"),
    Column("index", lambda row: named_key(row.key)[0]),
    Column("unit", lambda row: named_key(row.key)[1]),
    numeric("given", "given"),
    numeric("accuracy", "accuracy"),
    numeric("model", "predicted"),
    numeric("difference", "difference"),
    Column("95 % interval", lambda row: f"{number(row.low)} to {number(row.high)}"),
)

# ---- How well models from indices predict other manoeuvres, of published and measured ships: `make indices-report`.
# From turns with 35 degrees and 10/10 zigzags, to both sides, a model is made; it then sails turns with 20 degrees
# and 20/20 zigzags. Indices are means of both sides.

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


class TriedIndex(NamedTuple):
    """An index of a ship, her own and of the model, whose relative error is the last."""

    manoeuvre: str
    key: str
    own: float
    model: float
    error: float


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
    both = [(text, key, own[text][key], of_model[text][key]) for text in own for key in own[text]]
    return found, [TriedIndex(*one, one[3] / one[2] - 1.0) for one in both]


def published_page(ships: Sequence[TriedShip]) -> str:
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


MANOEUVRE = (field("manoeuvre"), Column("", lambda row: "given" if row.manoeuvre in GIVEN else "left out"))
ERROR = numeric("error", "error", percent)


def _table(rows: Sequence[TriedIndex]) -> Table:
    index = Column("index", lambda row: " ".join(named_key(row.key)).strip())
    return make_table([*MANOEUVRE, index, numeric("ship", "own"), numeric("model", "model"), ERROR], rows)


def _summary(rows: Sequence[TriedIndex]) -> Table:
    """Root mean square errors over the ships."""
    pooled = []
    for manoeuvre, key in dict.fromkeys((row.manoeuvre, row.key) for row in rows):
        errors = [row.error for row in rows if (row.manoeuvre, row.key) == (manoeuvre, key)]
        pooled.append(TriedIndex(manoeuvre, key, math.nan, math.nan, float(np.sqrt(np.mean(np.square(errors))))))
    return make_table([*MANOEUVRE, Column("index", lambda row: named_key(row.key)[0]), ERROR], pooled)


def main(folder: str) -> None:
    """Write README.md into a folder."""
    make_folder(Path(folder))
    ships = [*map(published_ship, VESSELS), measured_ship()]
    write_atomic(Path(folder) / "README.md", published_page(ships).encode())


if __name__ == "__main__":
    main(sys.argv[1])
