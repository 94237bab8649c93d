"""What a model from manoeuvring indices says: parameters and indices with intervals."""

from __future__ import annotations

from typing import TYPE_CHECKING

from ..numbers import number
from ..page import FAIR, GOOD, Verdict, items, result_page
from ..tables import Column, Table, make_table

if TYPE_CHECKING:
    from ...estimation.indices.result import ModelFromIndices, ParameterRow
    from ..page import Page

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
        seen=[index_table(result)],
        changed=[parameter_table(result)],
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


def parameter_table(result: ModelFromIndices) -> Table:
    """Parameters with their intervals."""
    return make_table(
        (
            Column("parameter", lambda row: row.name),
            Column("value", lambda row: number(row.value), lambda row: row.value),
            Column("95 % interval", _interval),
        ),
        result.parameters,
    )


def _interval(row: ParameterRow) -> str:
    return f"{number(row.interval[0])} to {number(row.interval[1])}" if row.interval else "not determined"


def index_table(result: ModelFromIndices) -> Table:
    """Indices given and of the model."""
    return make_table(
        (
            Column("manoeuvre", lambda row: row.manoeuvre),
            Column("index", lambda row: named_key(row.key)[0]),
            Column("unit", lambda row: named_key(row.key)[1]),
            Column("given", lambda row: number(row.given), lambda row: row.given),
            Column("accuracy", lambda row: number(row.accuracy), lambda row: row.accuracy),
            Column("model", lambda row: number(row.predicted), lambda row: row.predicted),
            Column("difference", lambda row: number(row.difference), lambda row: row.difference),
            Column("95 % interval", lambda row: f"{number(row.low)} to {number(row.high)}"),
        ),
        result.indices,
    )
