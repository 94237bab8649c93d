"""Which rows and columns of a table are wanted: those of one vessel of several, of the model or of the ship."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from collections.abc import Mapping as Dict
from dataclasses import dataclass, replace
from functools import cache
from itertools import combinations
from typing import TypeAlias

import numpy as np

from ...models.errors import BadInput
from ..io import MIN_SAMPLES
from .draft import NOT_USED, Answer, Question
from .evidence import ClockSeries, rate_ratio
from .headers import read_header
from .mapping import Mapping, scalar
from .names import is_time, joined, named, words
from .quantities import names_in, quantities, unit_of, vocabulary, word_list
from .raw import RawColumn, RawTable
from .times import find_time

VESSEL = "vessel"
"""Id of the question which vessel is wanted."""
SURE = 2
"""Of so many groups of the identifiers, distinct values mean distinct vessels; of the others where the rows tell it."""
MOST_SHOWN = 12


Groups: TypeAlias = tuple[RawColumn, Dict[str, np.ndarray]]
"""The column that says whose the rows of a table are, and the rows of each value with enough of them."""


def of_one_vessel(
    tables: Sequence[RawTable], mapping: Mapping | None, answers: Dict[str, str]
) -> tuple[list[RawTable], Question | None]:
    """The tables with the rows of one vessel, as the map or the answer says; and the question which one, if it is open.

    Raises
    ------
    BadInput : the answer is none of the vessels.
    """
    groups = {table.label: found for table in tables if (found := _groups(table)) is not None}
    names = list(dict.fromkeys(name for _, rows in groups.values() for name in rows))
    mapped = mapping.rows_of if mapping is not None else None
    wanted = answers.get(VESSEL) or (str(mapped) if mapped is not None else None)
    if wanted is not None and names and wanted not in names:
        raise BadInput(f"{wanted!r} is no vessel of the log", hint=f"give one of: {', '.join(names[:MOST_SHOWN])}")
    question = _which_vessel(tables, groups, names) if len(names) > 1 and wanted is None else None
    first = question.answers[0].key if question is not None else next(iter(names), None)
    used = []
    for table in tables:
        if table.label in groups:
            column, known = groups[table.label]
            name = str(wanted or first) if (wanted or first) in known else ""
            rows = known.get(name, np.zeros(0, dtype=int))
            told = f"{rows.size} of {table.n} rows are of {column.name} {name}; those of others are left out"
            table = table if rows.size == table.n else table.at(rows, done=(*table.done, told))
        used += [_without_unknown(table)] if table.n else []
    return used, question


@cache
def _identifiers() -> list[frozenset[str]]:
    """Names of columns that say whose a row is, without what separates their words, the most certain first."""
    return [frozenset(map(joined, names_in(text))) for text in vocabulary()["identifiers"]]


def _groups(table: RawTable) -> Groups | None:
    """The rows of each vessel; None where nothing says whose they are."""
    for rank, known in enumerate(_identifiers()):
        for column in (c for c in table.columns if joined(c.name) in known):
            rows = _rows_of(column)
            if (rows and rank < SURE) or (len(rows) > 1 and _tells(table, rows)):
                enough = {name: own for name, own in rows.items() if own.size >= MIN_SAMPLES}
                return (column, enough) if enough else None
    return None


def _rows_of(column: RawColumn) -> dict[str, np.ndarray]:
    """Value of a column, no gap -> its rows, those with the most first."""
    cells = column.numbers if column.texts is None else column.texts.trimmed
    values, place, counts = np.unique(cells, return_inverse=True, return_counts=True)
    if column.texts is None and values.size > 0.2 * cells.size:
        return {}
    order = np.argsort(-counts, kind="stable")
    sorted_rows = np.split(np.argsort(place, kind="stable"), np.cumsum(counts)[:-1])
    texts = [f"{value:.12g}" if isinstance(value, float) else str(value) for value in values.tolist()]
    unknown = ("", "nan", "0", "IMO0000000")
    return {texts[i]: np.sort(sorted_rows[i]) for i in order if texts[i] not in unknown}


def _tells(table: RawTable, rows: Dict[str, np.ndarray]) -> bool:
    """Whether values of a vague name are those of vessels: each with enough rows at the times of others."""
    large = [own for own in rows.values() if own.size >= MIN_SAMPLES]
    if len(large) < 2 or sum(own.size for own in large) < 0.9 * table.n:
        return False
    stays = sum(own.size - 1 for own in large) / max(1, table.n - 1)
    kept = [table.at(own) for own in large]
    filled = {frozenset(c.name for c in t.columns if np.isfinite(c.numbers).any()) for t in kept}
    may_be = [{quantity for column in t.columns for quantity in _may_be(column)} for t in kept]
    tracked = all(own & {"latitude", "north", "heading", "yaw_rate"} for own in may_be)
    return stays > 0.5 and len(filled) == 1 and tracked and _tells_time(table, large)


def _tells_time(table: RawTable, groups: Sequence[np.ndarray]) -> bool:
    """Whether the groups overlap in time: their rows alternate, or the time starts again with each."""
    first, *others = groups
    if any(((own > first[0]) & (own < first[-1])).sum() >= MIN_SAMPLES // 2 for own in others):
        return True
    time = find_time(table, None, {}).seconds(table)
    return time is not None and bool((np.diff(time[0]) < 0.0).any())


def _may_be(column: RawColumn) -> tuple[str, ...]:
    return (column.known,) if column.known else named(words(column.name)).may_be


def _which_vessel(tables: Sequence[RawTable], groups: Dict[str, Groups], names: Sequence[str]) -> Question:
    counts = {name: sum(rows[name].size for _, rows in groups.values() if name in rows) for name in names}
    known = {name: sum(_known_cells(t, groups[t.label], name) for t in tables if t.label in groups) for name in names}
    ordered = sorted(names, key=lambda name: (-counts[name], -known[name]))
    label = next(iter(groups))
    answers = tuple(
        Answer(name, f"{name}{_called(tables, groups, name)}: {counts[name]} rows", f"rows_of: {scalar(name)}")
        for name in ordered[:MOST_SHOWN]
    )
    column, _ = groups[label]
    text = f"The rows are of {len(names)} vessels, by column {column.name!r}: which one is wanted?"
    number = f"{column.name} of another of them: rows_of: NUMBER" if len(names) > MOST_SHOWN else ""
    return Question(VESSEL, "file", label, column.name, text, answers, number)


def _known_cells(table: RawTable, groups: Groups, name: str) -> int:
    """How many cells of a vessel's rows tell something of its motion."""
    own = _without_unknown(table.at(groups[1][name])) if name in groups[1] else None
    told = [c for c in own.columns if c.numeric and np.nanmax(c.numbers) > np.nanmin(c.numbers)] if own else []
    return sum(int(np.isfinite(column.numbers).sum()) for column in told)


def _called(tables: Sequence[RawTable], groups: Dict[str, Groups], name: str) -> str:
    """The name of a vessel beside its identifier."""
    for table in tables:
        rows = groups[table.label][1].get(name) if table.label in groups else None
        column = next((c for c in table.columns if joined(c.name) in _identifiers()[3]), None)
        if rows is not None and column is not None and column is not groups[table.label][0]:
            return f" ({column.text(int(rows[0]))})" if column.text(int(rows[0])) else ""
    return ""


def _without_unknown(table: RawTable) -> RawTable:
    """A table with gaps where AIS says 'not available'; of other tables headings of 511 deg among those to 360."""
    ais = any("mmsi" in words(column.name) for column in table.columns)
    if ais:
        indicators = [f"{c.name}: AIS's indicator, made deg/min" for c in table.columns if _is_indicator(c)]
        table = table.told(_with_unit_of_ais, "of AIS: speeds in knots, angles in degrees", *indicators)
    unknown = {column.name: places for column in table.columns if (places := _unknown(column, ais)).any()}
    if not unknown:
        return table
    told = (f"{name}: {int(k.sum())} cells say 'not available' (AIS), taken as gaps" for name, k in unknown.items())

    def with_gaps(c: RawColumn) -> RawColumn:
        return replace(c, values=np.where(unknown[c.name], np.nan, c.cells.numbers)) if c.name in unknown else c

    return table.told(with_gaps, *told)


def _with_unit_of_ais(column: RawColumn) -> RawColumn:
    """A column of a table of AIS with the unit that the messages have, where the file states none."""
    may_be = _may_be(column)
    if _is_indicator(column):
        rates = np.sign(column.numbers) * (column.numbers / PER_ROOT) ** 2
        return replace(column, values=np.where(np.abs(column.numbers) < INDICATORS, rates, np.nan), unit="deg/min")
    if column.unit or column.known or read_header(column.name, "").units:
        return column
    if "speed_over_ground" in may_be and column.numeric and not np.any(np.nan_to_num(column.numbers) % 1.0):
        return column  # whole numbers: knots, or tenths of them as the messages hold
    return replace(column, unit=next((unit for q in may_be if (unit := quantities()[q].unit_of_ais)), ""))


PER_ROOT, INDICATORS = 4.733, 127
"""AIS's indicator of the rate of turn over the root of deg/min, and the size from which on it tells no rate (ITU-R
M.1371)."""


def _is_indicator(column: RawColumn) -> bool:
    """Whether a column of AIS holds that indicator: whole numbers, and not those of decoded rates in whole deg/min."""
    if "yaw_rate" not in _may_be(column) or column.unit or column.known or not column.numeric:
        return False
    sizes, decoded = np.abs(column.finite), (np.arange(INDICATORS) / PER_ROOT) ** 2
    able = sizes[sizes < INDICATORS]
    whole = not np.any(able % 1.0) and float(sizes.max()) <= INDICATORS + 1
    return whole and not any(np.isin(able, made(decoded)).all() for made in (np.round, np.floor))


def _unknown(column: RawColumn, ais: bool) -> np.ndarray:
    """(N,) whether a cell holds what AIS sends for 'not available'."""
    wanted = next((q for q in _may_be(column) if q in quantities() and quantities()[q].unknown_to_ais), None)
    if wanted is None or not (ais or wanted == "heading") or not column.numeric:
        return np.zeros(1, dtype=bool)
    cells = column.cells.numbers
    unknown = np.isin(np.round(cells, 3), quantities()[wanted].unknown_to_ais)
    rest = cells[~unknown & np.isfinite(cells)]
    return unknown if ais or (rest.size and 6.3 < np.abs(rest).max() <= 360.0) else np.zeros(1, dtype=bool)


# ---- Columns of a model and of the ship in one table: told by names and constant factors; one scale is chosen.

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
    two = {table.label: found for table in tables if (found := _by_names(table) or _by_factors(table)) is not None}
    wanted = answers.get(SCALE) or (mapping.scale if mapping is not None else None)
    question = _which_scale(tables, two) if two and wanted is None else None
    return [_of(t, two[t.label], wanted or MODEL) if t.label in two else t for t in tables], question


def _by_names(table: RawTable) -> TwoScales | None:
    for mark in vocabulary()["scales"]:
        model, ship = (frozenset(mark[scale].split()) for scale in (MODEL, SHIP))
        own = {c.name: base for c in table.columns if (base := _without(c.name, model)) is not None}
        other = {c.name: base for c in table.columns if (base := _without(c.name, ship)) is not None}
        own = {name: base for name, base in own.items() if name not in other}
        pairs = tuple((one, two) for one, a in own.items() for two, b in other.items() if a == b and a)
        columns = {column.name: column for column in table.columns}
        tried = [_size(columns[one], columns[two], _dimension(columns[one], own[one])) for one, two in pairs]
        sizes = [size for size in tried if LEAST < size < LARGEST]
        letters = len(model) == 1
        if len(sizes) < (2 if letters else 1) or not _agree(sizes):
            continue
        if letters:
            paired = {name for pair in pairs for name in pair}
            own, other = ({name: side[name] for name in side if name in paired} for side in (own, other))
        return TwoScales(float(np.median(sizes)), own, other, pairs)
    return None


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


def _by_factors(table: RawTable) -> TwoScales | None:
    """Two scales without marks in their names: columns of equal quantities by factors of one scale, for two or more
    dimensions."""
    named_ones = [(c, _dimension(c, " ".join(words(c.name)))) for c in table.columns if not c.known]
    told = [(c, dimension) for c, dimension in named_ones if EXPONENTS.get(dimension)]
    found: list[tuple[float, str, str, str]] = []
    for (one, first), (two, second) in combinations(told, 2):
        kinds = [("time",) if is_time(c.name) else named(words(c.name)).may_be for c in (one, two)]
        if first == second and kinds[0] and kinds[0] == kinds[1]:
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


def _of(table: RawTable, two: TwoScales, wanted: str) -> RawTable:
    """A table without the columns of the other scale, and with the time of the one that is wanted."""
    used, other = two.of(wanted)
    said = f"of the {SHIP if wanted == MODEL else MODEL}: the scale 1 : {two.size:.4g} of the {wanted} is wanted"

    def told(c: RawColumn) -> RawColumn:
        if c.name in other:
            return replace(c, known=NOT_USED, source=said)
        return replace(c, called=used.get(c.name, c.called))

    done = f"columns of a {wanted} are used, of two scales 1 : {two.size:.4g}"
    chosen = table.told(told, done)
    times = [c for c in table.columns if is_time(used.get(c.name) or other.get(c.name) or c.name) and c.numeric]
    common = next((c for c in times if c.name not in other), None)
    own = any(c.name in used for c in times) or not times
    if own or (common is not None and _scale_of_time(table, two) in ("", wanted)):
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


def _which_scale(tables: Iterable[RawTable], two: Dict[str, TwoScales]) -> Question:
    label, found = next(iter(two.items()))
    column = found.pairs[0][0]
    shown = "; ".join(f"{one} and {other}" for one, other in found.pairs[:6])
    text = f"The columns are of two scales, 1 : {found.size:.4g} ({shown}): which one is wanted?"
    answers = (
        Answer(MODEL, f"the model: {', '.join(p[0] for p in found.pairs)}", f"scale: {MODEL}"),
        Answer(SHIP, f"the ship: {', '.join(p[1] for p in found.pairs)}", f"scale: {SHIP}"),
    )
    return Question(SCALE, "file", label, column, text, answers)
