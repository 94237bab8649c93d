"""What is found out about a column: quantity, unit, sign, how surely, and what is asked."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import TypeAlias

import numpy as np

from .draft import NOT_USED, About, Answer, Question, Sure
from .mapping import flow
from .quantities import LogUnit, candidates, quantities
from .raw import RawColumn, RawTable

Option: TypeAlias = tuple[str, str, Mapping[str, object]]
"""An answer about a column: key, text, changes of the map's line."""
LEVELS: tuple[Sure, ...] = ("stated", "other channel", "physics", "guess")
AS_RECORD = "as the record's positive rudder"
WITH_SIDE = ("rudder", "rudder_command")
"""Quantities whose sign is the side of the record's positive rudder."""
EITHER_SIDE = (*WITH_SIDE, "roll")
"""Angles that lie on either side of zero, also where a file counts them round the full circle."""
OPTIONAL = ("roll", "roll_rate")
"""Quantities without which a record is right."""


@dataclass(frozen=True)
class ColumnFinding:
    """A column and what is known of it.

    may_be : quantities that the name may mean, likeliest first; one where it is known, none where it is not used.
    unit, factor, offset, sign : value = sign * unit * (factor * number) + offset in the unit; unit None: open.
    signed : whether the sign is known.  side : side of a positive rudder where it is stated.  foreign : a stated
    unit that is none of the quantity.  unread : a text at the place of a unit that is none that is known.
    """

    table: RawTable
    column: RawColumn
    may_be: tuple[str, ...] = ()
    unit: LogUnit | None = None
    factor: float = 1.0
    offset: float = 0.0
    sign: int = 1
    signed: bool = False
    side: str = ""
    foreign: str = ""
    unread: str = ""
    sure: Sure = "stated"
    why: tuple[str, ...] = ()
    questions: tuple[Question, ...] = ()
    waits: bool = False
    """Whether another question must have its answer before it is known whether the column is used."""
    bounded: tuple[About, ...] = ()
    """What the user decided, by the map or an answer: it is not checked again."""

    @property
    def quantity(self) -> str | None:
        """The quantity, None where it is open or the column is not used."""
        return self.may_be[0] if len(self.may_be) == 1 else None

    @property
    def dimension(self) -> str:
        """Dimension of the first quantity that it may be."""
        return quantities()[self.may_be[0]].dimension

    def values(self, unit: LogUnit | None = None) -> np.ndarray:
        """(N,) in SI units and radians, with another unit if one is given."""
        used = unit or self.unit
        assert used is not None
        numbers = self.column.degrees if used.name == "deg min" else self.column.numbers
        found = self.sign * used.factor * self.factor * numbers + self.offset * used.factor
        return either_side(found) if self.quantity in EITHER_SIDE else found

    def told(self, sure: Sure, why: str, **changes: object) -> ColumnFinding:
        """The finding with more that is known: as sure as the least sure of it."""
        level = max(self.sure, sure, key=LEVELS.index)
        return replace(self, sure=level, why=(*self.why, why), **changes)

    def unused(self, why: str, waits: bool = False) -> ColumnFinding:
        """The finding of a column that is not used, or not until another question has its answer."""
        return replace(self, may_be=(), unit=None, why=(why,), sure="stated", questions=(), signed=False, waits=waits)

    @property
    def convention(self) -> str:
        """The sign convention in words; '' where there is none or it is open."""
        quantity = self.quantity
        if quantity is None or not self.signed:
            return ""
        if quantity in WITH_SIDE and self.side:
            return f"positive to {self.side}"
        if quantity in WITH_SIDE and self.sign > 0:
            return AS_RECORD
        if self.offset and quantity == "heading" and self.sign < 0:
            return "counterclockwise from east"
        facts = quantities()[quantity]
        return (facts.turned or "turned round") if self.sign < 0 else facts.convention


def either_side(angles: np.ndarray) -> np.ndarray:
    """Angles (N,), rad: of those that count round the full circle the ones beyond a half turn are negative."""
    turned = np.nan_to_num(np.abs(angles)) > np.pi
    return np.where(turned, (angles + np.pi) % (2.0 * np.pi) - np.pi, angles) if turned.any() else angles


def is_full_circle(finding: ColumnFinding) -> bool:
    """Whether angles go from zero to a full turn, in degrees or radians, and lie at both ends of it."""
    known = finding.column.finite
    turn = 360.0 if known.size and known.max() > 7.0 else 2.0 * np.pi
    return bool(
        known.size and known.min() >= 0.0 and 0.9 * turn < known.max() <= turn and np.mean(known < turn / 4.0) > 0.02
    )


def identifier(finding: ColumnFinding, about: About) -> str:
    """The id of a question about a column."""
    return f"{finding.table.label}/{finding.column.name}/{about}"


def line_of(finding: ColumnFinding, **changes: object) -> str:
    """The line of the map that says what a finding says, with changes."""
    entry: dict[str, object] = {"column": finding.column.name, "to": finding.quantity or "?"}
    entry["unit"] = finding.unit.name if finding.unit else "?"
    if finding.factor != 1.0:
        entry["factor"] = finding.factor
    if finding.offset != 0.0:
        entry["offset"] = finding.offset
    if finding.sign != 1:
        entry["sign"] = finding.sign
    entry |= changes
    if entry["to"] == NOT_USED:
        entry = {"column": finding.column.name, "to": NOT_USED}
    return flow(entry)


def _asking(
    finding: ColumnFinding,
    about: About,
    text: str,
    answers: Sequence[tuple[str, str, Mapping[str, object]]],
    **more: str,
) -> ColumnFinding:
    """The finding with a question of some answers, and that the column is not used."""
    every = (*answers, (NOT_USED, "do not use this column", {"to": NOT_USED}))
    made = tuple(Answer(key, said, line_of(finding, **changes)) for key, said, changes in every)
    place = finding.table.label, finding.column.name
    question = Question(identifier(finding, about), about, *place, text, made, **more)
    return replace(finding, questions=(*finding.questions, question), sure="guess")


def _without(finding: ColumnFinding) -> str:
    """The key that leaves out a column without which a record is right: a roll, a speed perhaps through the water."""
    may_go = finding.quantity in OPTIONAL or "speed_through_water" in finding.may_be
    return NOT_USED if may_go else ""


def ask_unit(finding: ColumnFinding, text: str, units: Sequence[LogUnit] | None = None) -> ColumnFinding:
    """The finding with a question for its unit."""
    answers = [(unit.name, unit.name, {"unit": unit.name}) for unit in units or candidates(finding.dimension)]
    return _asking(finding, "unit", text, answers, without=_without(finding))


def ask_scale(
    finding: ColumnFinding, text: str, number: str, unit: str, usual: Sequence[float], per: float, zero: float = 0.0
) -> ColumnFinding:
    """The finding with a question for the size of a number: answers and numbers are units for `per` of the column above
    the number `zero`."""
    answers = [
        (f"{size:g}", f"{size:g} {unit}",
         {"unit": unit, "factor": size / per} | ({"offset": -zero * size / per} if zero else {}))
        for size in usual
    ]  # fmt: skip
    return _asking(finding, "unit", text, answers, number=number)


def ask_sign(finding: ColumnFinding, text: str, answers: Sequence[Option]) -> ColumnFinding:
    """The finding with a question for its sign."""
    return _asking(finding, "sign", text, answers, without=_without(finding))


def ask_numbers(finding: ColumnFinding) -> ColumnFinding:
    """The finding with the question whether the commas of its numbers stand for thousands or for decimals."""
    first = next(iter(finding.column.first(1)), "")
    text = f"{finding.column.name!r}: does the comma of {first} stand for thousands or for decimals?"
    decimals = {"factor": 1e-3 * finding.factor}
    answers = [("thousands", "for thousands", {}), ("decimals", "for decimals", decimals)]
    return _asking(finding, "numbers", text, answers)


def ask_quantity(finding: ColumnFinding, text: str, may_be: Sequence[str]) -> ColumnFinding:
    """The finding with a question for its quantity."""
    answers = [(name, name.replace("_", " "), {"to": name}) for name in may_be]
    return _asking(finding, "quantity", text, answers, without=_without(finding))
