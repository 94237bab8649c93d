"""Proposal of a mapping: quantity, unit and confidence of columns, from names, units, ranges and each other."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from ..grammar import DEGREE
from .clock import DATED, TimeGuess, guess_form, seconds, spread
from .mapping import ColumnMap, TableMap, TimeMap
from .names import date_confidence, match, split_unit, time_confidence
from .quantities import NOT_USED, QUANTITIES
from .raw import RawColumn, RawTable
from .units import Unit, candidates, unit_of

SURE = 0.5
"""Confidence from which on a guess is used."""
LARGEST = {"rudder": 1.6, "rudder_command": 1.6, "roll": 1.6, "latitude": math.pi / 2.0, "longitude": 3.2}
FULL_TURN, MANY_TURNS = 6.4, 200.0
"""Largest sensible size of an angle, rad: where none is named a full turn, or many for one that may go on turning."""
FASTEST_M_S, FASTEST_RAD_S = 60.0, 3.0
"""Speed of anything afloat and its yaw rate, above which a unit is not believed."""


@dataclass(frozen=True)
class ColumnGuess:
    """What a column is taken for: quantity (None: kept aside), unit, sign, confidence from 0 to 1, and why."""

    column: RawColumn
    quantity: str | None
    unit: Unit | None = None
    sign: int = 1
    confidence: float = 0.0
    reason: str = ""


@dataclass(frozen=True)
class TableGuess:
    """Guesses for a table: time columns (none found: empty), their form, and every other column."""

    table: RawTable
    time_columns: tuple[str, ...]
    time: TimeGuess | None
    columns: tuple[ColumnGuess, ...]

    def mapping(self, least: float = SURE) -> TableMap | None:
        """What is at least so sure, as a mapping; None without a time or without a column."""
        used = [guess for guess in self.columns if guess.quantity and guess.unit and guess.confidence >= least]
        if self.time is None or not used:
            return None
        columns = tuple(
            ColumnMap(column=g.column.name, to=str(g.quantity), unit=g.unit.name, sign=1 if g.sign > 0 else -1)
            for g in used
            if g.unit is not None
        )
        time = TimeMap(columns=self.time_columns, form=self.time.form)
        return TableMap(file=self.table.file, sheet=self.table.sheet, time=time, columns=columns)


def guess_table(table: RawTable) -> TableGuess:
    """Guesses for all columns of a table."""
    names, form = _guess_time(table)
    others = [column for column in table.columns if column.name not in names]
    guesses = _once_each([_guess_column(column) for column in others])
    if form is None:
        return TableGuess(table, names, form, tuple(guesses))
    time, _ = spread(seconds([c for name in names if (c := table.column(name))], form.form))
    return TableGuess(table, names, form, tuple(_with_rates(guesses, time)))


# ------------------------------------------------------------------------------------------------ time


def _guess_time(table: RawTable) -> tuple[tuple[str, ...], TimeGuess | None]:
    """(columns of the time, their form) with the highest confidence; a form with a date before one without."""
    scored = []
    for place, column in enumerate(table.columns):
        named = max(time_confidence(column.name), 0.3 if place == 0 else 0.0)
        form = guess_form(column, column.unit or _time_unit(column.name))
        if form is not None and (named or form.form not in ("seconds", "hhmmss", "day fraction", "minutes")):
            share = 1.0 if named >= 0.9 else 0.85 if named else 0.7
            dated = 0.02 if form.form in DATED else 0.0
            scored.append((form.confidence * share + dated, column, replace(form, confidence=form.confidence * share)))
    if not scored:
        return (), None
    _, column, form = max(scored, key=lambda entry: entry[0])
    return _with_date(table, column, form)


def _time_unit(name: str) -> str:
    from .names import words

    last = words(name)[-1:] or ("",)
    return last[0] if last[0] in ("ms", "s", "min", "sec", "msec", "hhmmss") else ""


def _with_date(table: RawTable, column: RawColumn, form: TimeGuess) -> tuple[tuple[str, ...], TimeGuess]:
    """The time with the column of the date, where the time is a time of day or a date alone."""
    if form.form in ("clock", "hhmmss", "day fraction"):
        dates = [c for c in table.columns if c is not column and date_confidence(c.name)]
        for date in dates:
            own = guess_form(date, "")
            if own is not None and own.form in ("iso", "day first", "month first", "excel"):
                return (date.name, column.name), TimeGuess(own.form, min(own.confidence, form.confidence), own.reason)
    if form.form in ("iso", "day first", "month first") and not any(":" in text for text in column.first(5)):
        for clock in (c for c in table.columns if c is not column):
            own = guess_form(clock, "")
            if own is not None and own.form in ("clock", "hhmmss"):
                return (column.name, clock.name), form
    return (column.name,), form


# ------------------------------------------------------------------------------------------------ columns


def _guess_column(column: RawColumn) -> ColumnGuess:
    quantity, confidence, reason = match(column.name)
    if quantity is None:
        return ColumnGuess(column, None, reason=reason)
    if quantity in NOT_USED:
        return ColumnGuess(column, None, reason=NOT_USED[quantity])
    known = np.isfinite(column.numbers)
    if not known.any():
        if quantity in ("latitude", "longitude") and column.first(1):
            return ColumnGuess(column, quantity, unit_of("dms"), 1, confidence, f"{reason}, degrees and minutes")
        return ColumnGuess(column, quantity, reason="no numbers in the column")
    unit, share, why = _unit(column, quantity)
    return ColumnGuess(column, quantity, unit, 1, confidence * share, f"{reason}, {why}")


def _unit(column: RawColumn, quantity: str) -> tuple[Unit | None, float, str]:
    """(unit, share of confidence that is left, why)."""
    dimension = QUANTITIES[quantity].dimension
    if column.unit:
        stated = unit_of(column.unit, dimension)
        if stated is None:
            return None, 0.0, f"unit {column.unit!r} is none of {quantity}"
        return stated, *_sensible(column, quantity, stated, "unit stated")
    _, suffix = split_unit(column.name)
    if suffix is not None and suffix.dimension == dimension:
        return suffix, *_sensible(column, quantity, suffix, "unit in the name")
    return _unit_by_range(column, quantity)


def _size(column: RawColumn) -> float:
    known = np.abs(column.numbers[np.isfinite(column.numbers)])
    return float(np.quantile(known, 0.99)) if known.size else 0.0


def _limit(quantity: str) -> float:
    dimension = QUANTITIES[quantity].dimension
    if dimension == "angle":
        return LARGEST.get(quantity, FULL_TURN)
    return {"speed": FASTEST_M_S, "angular rate": FASTEST_RAD_S}.get(dimension, math.inf)


def _sensible(column: RawColumn, quantity: str, unit: Unit, why: str) -> tuple[float, str]:
    size = _size(column) * unit.factor
    limit = MANY_TURNS if QUANTITIES[quantity].wraps else _limit(quantity)
    if size > 1.02 * limit:
        return 0.0, f"{why}, but values up to {_size(column):.4g} {unit.name} cannot be"
    return 1.0, why


def _unit_by_range(column: RawColumn, quantity: str) -> tuple[Unit | None, float, str]:
    """The unit that the numbers allow, where neither name nor header say it."""
    usual = unit_of(QUANTITIES[quantity].usual, QUANTITIES[quantity].dimension)
    size = _size(column)
    if QUANTITIES[quantity].dimension == "angle":
        radians = size <= _limit(quantity)
        if not radians:
            return usual, 0.95, f"values up to {size:.4g} can only be degrees"
        if QUANTITIES[quantity].wraps and size > 2.0:
            return unit_of("rad", "angle"), 0.7, f"values up to {size:.4g}, taken as radians"
        small = size < 0.8
        return unit_of("rad", "angle") if small else usual, 0.55, "no unit stated, told by the range"
    if QUANTITIES[quantity].dimension == "rotation" and size < 15.0:
        return unit_of("rps"), 0.6, "no unit stated, told by the range"
    return usual, 0.65, f"no unit stated, taken as {usual.name if usual else '?'}"


def _once_each(guesses: Sequence[ColumnGuess]) -> list[ColumnGuess]:
    """Of columns that are taken for the same quantity the surest stays, the others are kept aside."""
    best: dict[str, ColumnGuess] = {}
    for guess in guesses:
        if guess.quantity and (guess.quantity not in best or guess.confidence > best[guess.quantity].confidence):
            best[guess.quantity] = guess
    return [g if g.quantity is None or best[g.quantity] is g else _set_aside(g, best[g.quantity]) for g in guesses]


def _set_aside(guess: ColumnGuess, better: ColumnGuess) -> ColumnGuess:
    reason = f"{guess.quantity} is taken from {better.column.name}"
    return replace(guess, quantity=None, confidence=0.0, reason=reason)


# ------------------------------------------------------------------------------------------------ against each other


def _with_rates(guesses: Sequence[ColumnGuess], time: np.ndarray) -> list[ColumnGuess]:
    """Unit and sign of the yaw rate from the heading's changes, where unit or sign are not certain otherwise."""
    heading = next((g for g in guesses if g.quantity in ("heading", "heading_magnetic") and g.unit), None)
    if heading is None or heading.unit is None:
        return list(guesses)
    out = []
    for guess in guesses:
        out.append(_checked_rate(guess, heading, time) if guess.quantity == "yaw_rate" and guess.unit else guess)
    return out


def _checked_rate(guess: ColumnGuess, heading: ColumnGuess, time: np.ndarray) -> ColumnGuess:
    assert heading.unit is not None and guess.unit is not None
    slope = rate_ratio(heading.column.numbers * heading.unit.factor, guess.column.numbers, time)
    if slope is None:
        return guess
    stated = "no unit stated" not in guess.reason
    sign = 1 if slope > 0.0 else -1
    turned = "" if sign > 0 else "; its sign is opposite to the heading's"
    units = (guess.unit,) if stated else candidates("angular rate")
    best = min(units, key=lambda unit: abs(math.log(abs(slope) / unit.factor)))
    miss = abs(abs(slope) / best.factor - 1.0)
    if miss < 0.25:
        confidence = min(0.95, max(guess.confidence, 0.9 if not stated else 0.95))
        return replace(guess, unit=best, sign=sign, confidence=confidence, reason=f"agrees with the heading{turned}")
    why = f"{guess.reason}, but the heading changes {abs(slope) / best.factor:.3g} times as fast"
    if not stated:
        return replace(guess, confidence=0.4, reason=why)
    near = min(candidates("angular rate"), key=lambda unit: abs(math.log(abs(slope) / unit.factor)))
    told = f"; {near.name}?" if abs(abs(slope) / near.factor - 1.0) < 0.1 else ""
    return replace(guess, sign=sign, confidence=min(guess.confidence, 0.45), reason=why + told)


def rate_ratio(angle: np.ndarray, rate: np.ndarray, time: np.ndarray) -> float | None:
    """Changes of an angle (N,), rad, over those of the integral of a rate (N,); None where they do not correlate."""
    known = np.isfinite(angle) & np.isfinite(rate) & np.isfinite(time)
    if known.sum() < 20:
        return None
    angle, rate, time = np.unwrap(angle[known]), rate[known], time[known]
    integral = np.concatenate([[0.0], np.cumsum(np.diff(time) * (rate[1:] + rate[:-1]) / 2.0)])
    window = max(1, min(known.sum() // 10, 50))
    change, sum_ = angle[window:] - angle[:-window], integral[window:] - integral[:-window]
    power = float(np.sum(sum_**2))
    if power <= 0.0 or float(np.std(change)) < 0.1 * DEGREE:
        return None
    correlation = float(np.sum(change * sum_) / math.sqrt(power * np.sum(change**2)))
    return float(np.sum(change**2) / np.sum(change * sum_)) if abs(correlation) > 0.9 else None
