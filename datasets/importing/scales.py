"""Columns of a model and of the ship in one table: told by names and constant factors; one scale is chosen."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from collections.abc import Mapping as Dict
from dataclasses import dataclass, replace
from itertools import combinations

import numpy as np

from .draft import NOT_USED, Answer, Question
from .evidence import ClockSeries, rate_ratio
from .mapping import Mapping
from .names import is_time, named, words
from .quantities import quantities, vocabulary, word_list
from .raw import RawColumn, RawTable
from .times import find_time
from .units import unit_of

SCALE = "scale"
"""Id of the question which scale is wanted."""
MODEL, SHIP = "model", "ship"
EXPONENTS = {name: facts["froude"] for name, facts in vocabulary()["dimensions"].items()}
"""Dimension -> the power of the scale by which the ship's values are larger (Froude)."""
LEAST, LARGEST = 1.5, 2000.0
"""Range of scales."""
NEAR = 0.03
"""How near scales of different columns must be, and how constant a factor."""


@dataclass(frozen=True)
class TwoScales:
    """The scale, columns of the model and of the ship by name with what they are called without the mark, and those of
    one quantity."""

    size: float
    model: Dict[str, str]
    ship: Dict[str, str]
    pairs: tuple[tuple[str, str], ...]

    def of(self, scale: str) -> tuple[Dict[str, str], Dict[str, str]]:
        """The columns of a scale, and those of the other one."""
        return (self.model, self.ship) if scale == MODEL else (self.ship, self.model)


def of_one_scale(
    tables: Sequence[RawTable], mapping: Mapping | None, answers: Dict[str, str]
) -> tuple[list[RawTable], Question | None]:
    """The tables with the columns of one scale, as the map or the answer says; and the question which one, if open."""
    two = {table.label: found for table in tables if (found := _by_marks(table) or _by_factors(table)) is not None}
    wanted = answers.get(SCALE) or (mapping.scale if mapping is not None else None)
    question = _which(tables, two) if two and wanted is None else None
    return [_of(t, two[t.label], wanted or MODEL) if t.label in two else t for t in tables], question


# ------------------------------------------------------------------------------------------------ by names


def _by_marks(table: RawTable) -> TwoScales | None:
    marks = ((frozenset(m["model"].split()), frozenset(m["ship"].split())) for m in vocabulary()["scales"])
    return next((found for own in marks if (found := _by_names(table, *own)) is not None), None)


def _by_names(table: RawTable, model: frozenset[str], ship: frozenset[str]) -> TwoScales | None:
    own = {c.name: base for c in table.columns if (base := _without(c.name, model)) is not None}
    other = {c.name: base for c in table.columns if (base := _without(c.name, ship)) is not None}
    own = {name: base for name, base in own.items() if name not in other}
    pairs = tuple((one, two) for one, a in own.items() for two, b in other.items() if a == b and a)
    columns = {column.name: column for column in table.columns}
    tried = [_size(columns[one], columns[two], _dimension(columns[one], own[one])) for one, two in pairs]
    sizes = [size for size in tried if LEAST < size < LARGEST]
    letters = len(model) == 1
    if len(sizes) < (2 if letters else 1) or not _agree(sizes):
        return None
    if letters:
        paired = {name for pair in pairs for name in pair}
        own, other = ({name: side[name] for name in side if name in paired} for side in (own, other))
    return TwoScales(float(np.median(sizes)), own, other, pairs)


def _without(name: str, marks: frozenset[str]) -> str | None:
    """A name without its mark of a scale; None where it has none."""
    parts = words(name)
    if not marks & set(parts):
        return None
    return " ".join(part for part in parts if part not in marks | word_list("beside_scale"))


def _size(one: RawColumn, two: RawColumn, dimension: str) -> float:
    """The scale of a column of the ship and one of the model, by their constant factor; 1 where they tell none."""
    exponent = EXPONENTS.get(dimension)
    ratio = _factor(one, two) if exponent else None
    return ratio ** (1.0 / exponent) if ratio is not None and ratio > 0.0 and exponent else 1.0


def _dimension(column: RawColumn, base: str) -> str:
    """Dimension of a column, by its name or its unit; '' where it is not known."""
    parts = words(base)
    if is_time(base):
        return "time"
    may_be = next((found for n in range(len(parts), 0, -1) if (found := named(parts[:n]).may_be)), ())
    known = {quantities()[quantity].dimension for quantity in may_be}
    unit = unit_of(column.unit) if column.unit else None
    return known.pop() if len(known) == 1 else unit.dimension if unit is not None else ""


def _factor(first: RawColumn, second: RawColumn) -> float | None:
    """The constant by which the second column is larger, both in their stated units; None where there is none."""
    if not (first.numeric and second.numeric):
        return None
    a, b = first.numbers * _unit_factor(first, 1.0), second.numbers * _unit_factor(second, 1.0)
    known = np.isfinite(a) & np.isfinite(b)
    a, b = a[known], b[known]
    power = float(a @ a)
    if a.size < 5 or not power > 0.0 or not np.ptp(a) > 0.0:
        return None
    ratio = float(a @ b) / power
    apart = float(np.quantile(np.abs(b - ratio * a), 0.95))
    return ratio if apart <= NEAR * float(np.quantile(np.abs(b - np.median(b)), 0.95)) + 1e-12 else None


def _unit_factor(column: RawColumn, usual: float) -> float:
    """The factor of the unit that a column states, or else the usual one."""
    unit = unit_of(column.unit) if column.unit else None
    return unit.factor if unit is not None else usual


def _agree(sizes: Sequence[float]) -> bool:
    middle = float(np.median(sizes))
    return all(abs(size / middle - 1.0) < 2.0 * NEAR for size in sizes)


# ------------------------------------------------------------------------------------------------ by factors


def _by_factors(table: RawTable) -> TwoScales | None:
    """Two scales without marks in their names: columns of equal quantities by factors of one scale, for two or more
    dimensions."""
    named_ones = [(c, _dimension(c, " ".join(words(c.name)))) for c in table.columns if not c.known]
    told = [(c, dimension) for c, dimension in named_ones if EXPONENTS.get(dimension)]
    found: list[tuple[float, str, str, str]] = []
    for (one, first), (two, second) in combinations(told, 2):
        if first == second and _same_name(one, two):
            size = _size(one, two, first)
            model, ship = (one, two) if size > 1.0 else (two, one)
            size = max(size, 1.0 / size)
            found += [(size, first, model.name, ship.name)] if LEAST < size < LARGEST else []
    if len({dimension for _, dimension, _, _ in found}) < 2 or not _agree([size for size, *_ in found]):
        return None
    own, other = {m: m for _, _, m, _ in found}, {s: s for _, _, _, s in found}
    if set(own) & set(other):
        return None
    return TwoScales(float(np.median([f[0] for f in found])), own, other, tuple((m, s) for _, _, m, s in found))


def _same_name(one: RawColumn, two: RawColumn) -> bool:
    """Whether two names mean the same quantity."""
    if is_time(one.name) and is_time(two.name):
        return True
    first, second = named(words(one.name)).may_be, named(words(two.name)).may_be
    return bool(first) and first == second


# ------------------------------------------------------------------------------------------------ one of them


def _of(table: RawTable, two: TwoScales, wanted: str) -> RawTable:
    """A table without the columns of the other scale, and with the time of the one that is wanted."""
    used, other = two.of(wanted)
    said = f"of the {SHIP if wanted == MODEL else MODEL}: the scale 1 : {two.size:.4g} of the {wanted} is wanted"

    def told(c: RawColumn) -> RawColumn:
        if c.name in other:
            return replace(c, known=NOT_USED, source=said)
        return replace(c, called=used.get(c.name, c.called))

    done = f"columns of a {wanted} are used, of two scales 1 : {two.size:.4g}"
    return _with_time(table, table.told(told, done), two, wanted)


def _with_time(table: RawTable, chosen: RawTable, two: TwoScales, wanted: str) -> RawTable:
    """The table of one scale with a time of it; `table`: that of both scales."""
    used, other = two.of(wanted)
    times = [c for c in table.columns if is_time(used.get(c.name) or other.get(c.name) or c.name) and c.numeric]
    if not times or any(c.name in used for c in times):
        return chosen
    common = next((c for c in times if c.name not in other), None)
    if common is not None and _scale_of_time(table, two) in ("", wanted):
        return chosen
    base = common or times[0]
    factor = math.sqrt(two.size) if wanted == SHIP else 1.0 / math.sqrt(two.size)
    made = replace(base, values=base.numbers * factor, called=other.get(base.name, ""))
    done = f"{base.name} is a time of the {SHIP if wanted == MODEL else MODEL}: times {factor:.4g}"
    return chosen.told(lambda c: made if c.name == base.name else c, done)


def _scale_of_time(table: RawTable, two: TwoScales) -> str:
    """Of which scale a time without a mark is, by a heading and a yaw rate; '' where nothing tells it."""
    marked = {**two.model, **two.ship}
    time = find_time(replace(table, columns=tuple(c for c in table.columns if c.name not in marked)), None, {})
    seconds = time.seconds(table)
    angle = next((c for c in table.columns if named(words(c.name)).may_be[:1] == ("heading",)), None)
    if seconds is None or angle is None:
        return ""
    rates = [c for c in table.columns if c.name in marked and _dimension(c, marked[c.name]) == "angular rate"]
    heading, *series = (
        ClockSeries(seconds[0], c.numbers * _unit_factor(c, math.radians(1.0)), "", False) for c in (angle, *rates)
    )
    for rate, own in zip(rates, series, strict=True):
        ratio = rate_ratio(heading, own)
        if ratio is not None and abs(math.log(abs(ratio))) < 0.25 * math.log(two.size):
            return MODEL if rate.name in two.model else SHIP
    return ""


def _which(tables: Iterable[RawTable], two: Dict[str, TwoScales]) -> Question:
    label, found = next(iter(two.items()))
    column = found.pairs[0][0]
    shown = "; ".join(f"{one} and {other}" for one, other in found.pairs[:6])
    text = f"The columns are of two scales, 1 : {found.size:.4g} ({shown}): which one is wanted?"
    answers = (
        Answer(MODEL, f"the model: {', '.join(p[0] for p in found.pairs)}", f"scale: {MODEL}"),
        Answer(SHIP, f"the ship: {', '.join(p[1] for p in found.pairs)}", f"scale: {SHIP}"),
    )
    return Question(SCALE, "file", label, column, text, answers)
