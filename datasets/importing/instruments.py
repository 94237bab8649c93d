"""Tables whose rows come from several instruments: one table for every instrument, or for every named value."""

from __future__ import annotations

import itertools
import re
from collections.abc import Iterator, Sequence
from dataclasses import replace

import numpy as np

from .cells import GAPS, Texts
from .clock import guess_form
from .names import is_date, is_time, joined, listed, named, part_of_time, words
from .raw import RawColumn, RawTable, faults_once

TALKERS, NAMES, NUMBERS = listed("talkers"), listed("parameters"), listed("devices")
VALUES, UNITS = listed("values"), listed("unit_columns")
AS_LONG = 0.05
"""Relative difference of their lengths from which on two times are not the same."""
ALWAYS, FEWEST = 0.98, 10
"""Share of the rows from which on a column is filled in all, and rows of the least instrument."""
SAMPLE = 400
"""Rows that tell whether a table may have columns of sensors with times of their own."""
MOST = 60
"""Different names in a column that still names instruments or values."""


def by_instrument(table: RawTable) -> list[RawTable]:
    """The tables of a table: one for every named value in long form, one for every talker, or the table itself."""
    name, value = _texts(table, NAMES), next((c for c in table.columns if joined(c.name) in VALUES), None)
    if all(column.name.startswith("column ") for column in table.columns):
        name = value = None  # a long form without a header: a time, a few different words, a number
        if 3 <= len(table.columns) <= 4 and guess_form(table.columns[0], "") is not None:
            labels, numbers = table.columns[1:3]
            kinds = labels.texts.unique() if labels.texts is not None and not labels.numeric else []
            if 1 < len(kinds) <= MOST and all(re.search(r"[^\W\d]{2}", kind) for kind in kinds):
                name, value = labels, numbers
    talker = _texts(table, TALKERS)
    if name is None and value is not None:  # and no numbers besides a time and the number of a device
        others = (c for c in table.columns if c is not value and not is_time(c.name) and joined(c.name) not in NUMBERS)
        name = None if any(column.numeric for column in others) else talker or _numbered(table)
    if name is not None and value is not None and value.numeric:
        return _long(table, _with_fields(table, name), value)
    if talker is not None:
        return _parts(table, talker)
    return [part for block in _by_time(table) for part in _by_filling(block)]


def _with_fields(table: RawTable, name: RawColumn) -> RawColumn:
    """The names of the values of a long form; where each stands for several fields, whose names another column holds,
    `message/field`, or `message/message field` where the field alone says too little."""
    rest = replace(table, columns=tuple(c for c in table.columns if c is not name))
    field = _texts(rest, NAMES)
    if field is None or field.texts is None or name.texts is None:
        return name
    pairs = list(zip(name.texts, field.texts, strict=True))
    if not len(set(pairs)) > len({one for one, _ in pairs}):
        return name
    texts = {pair: "/".join((pair[0], _of_field(*pair))).replace(", ", " ") for pair in set(pairs)}
    return replace(name, values=Texts(texts[pair] for pair in pairs))


def _of_field(message: str, field: str) -> str:
    """What a field of a message is called: by itself, by the message, of which it repeats words, or by both."""
    own = named(words(field))
    if own.may_be and not own.extra:
        return field
    return message if set(words(field)) <= set(words(message)) else f"{message} {field}"


def last_part(path: str) -> str:
    """The last part of a path of names such as `ship/nav/heading`."""
    return next((part for part in reversed(re.split(r"[./]", path)) if part.strip()), path)


def _filled(column: RawColumn) -> np.ndarray:
    """(N,) whether a cell holds something."""
    return ~column.texts.among(GAPS) if column.texts is not None else np.isfinite(column.numbers)


def _by_filling(table: RawTable) -> list[RawTable]:
    """A table for every group of columns that are filled in rows of their own: sensors with times of their own."""
    head = np.arange(min(table.n, SAMPLE))
    if sum(_filled(replace(c, values=c.at(head))).mean() <= ALWAYS for c in table.columns if table.n) < 2:
        return [table]
    masks = [_filled(column) for column in table.columns]
    groups: dict[bytes, list[int]] = {}
    for place, mask in enumerate(masks):
        if mask.any() and not mask.mean() > ALWAYS:
            groups.setdefault(mask.tobytes(), []).append(place)
    filled = [np.frombuffer(key, dtype=bool) for key in groups]
    apart = len(filled) > 1 and max(np.sum(filled, axis=0)) == 1 and min(f.sum() for f in filled) > FEWEST
    shared = [i for i, mask in enumerate(masks) if mask.mean() > ALWAYS]
    if not apart or not any(guess_form(table.columns[i], "") for i in shared):
        return [table]
    out = []
    for mask, places in zip(filled, groups.values(), strict=True):
        own = [table.columns[i] for i in sorted((*shared, *places))]
        names = ", ".join(table.columns[i].name for i in places)[:60]
        done = (*table.done, f"{names}: filled in rows of their own")
        out.append(table.at(np.flatnonzero(mask), own, sheet=names, done=done))
    return faults_once(out)


def _texts(table: RawTable, wanted: frozenset[str]) -> RawColumn | None:
    """The first column of that name that holds a few different texts."""
    for column in table.columns:
        if joined(column.name) in wanted and column.texts is not None and not column.numeric:
            kinds = [value for value in column.texts.unique() if value.lower() not in GAPS]
            if 1 < len(kinds) <= MOST:
                return column
    return None


def _numbered(table: RawTable) -> RawColumn | None:
    """Names `value 0`, `value 1`, ... of the values of a table, of a column of a few numbers that say of which device a
    row is."""
    for column in table.columns:
        if joined(column.name) in NUMBERS and column.numeric and np.isfinite(column.numbers).all():
            kinds, counts = np.unique(column.numbers, return_counts=True)
            if 1 < kinds.size <= MOST and counts.min() > FEWEST and np.mean(np.diff(column.numbers) != 0.0) > 0.5:
                return replace(column, values=[f"{column.name} {number:g}" for number in column.numbers], unit="")
    return None


def _by_time(table: RawTable) -> list[RawTable]:
    """A table for every column of a time, with the columns behind it, where they are sampled at other times."""
    parts = {part_of_time(column.name) for column in table.columns} >= {"hour", "minute", "second"}
    times = [is_time(c.name) and not is_date(c.name) and not (parts and part_of_time(c.name)) for c in table.columns]
    places = [i for i, c in enumerate(table.columns) if times[i] and _rises(c)]
    blocks = [table.columns[i:j] for i, j in itertools.pairwise([*places, len(table.columns)])]
    if len(blocks) < 2 or places[0] != 0 or min(map(len, blocks)) < 2 or not _apart([b[0] for b in blocks], blocks):
        return [table]
    out = []
    for time, *others in blocks:
        done = (*table.done, f"timed by its own column {time.name}")
        out.append(table.at(np.flatnonzero(~np.isnan(time.numbers)), (time, *others), sheet=time.name, done=done))
    return faults_once(out)


def _rises(column: RawColumn) -> bool:
    guess = guess_form(column, "")
    return guess is not None and not (column.numeric and np.mean(np.diff(column.numbers) < 0.0) > 0.02)


def _apart(times: Sequence[RawColumn], blocks: Sequence[Sequence[RawColumn]]) -> bool:
    """Whether times of one table are those of other samples: each is named as a column behind it or all alike, and they
    differ; or what is between them is not constant.  Numbers behind the first word are as one name."""
    if not all(column.numeric for column in times):
        return False
    between = [column.numbers - times[0].numbers for column in times[1:]]
    if all(np.nanmax(np.abs(gap)) == 0.0 for gap in between):
        return False
    told = [set(words(c.name)) - set(words("time zeit t s ms")) for c in times]
    named = all(own & {w for c in block[1:] for w in words(c.name)} for own, block in zip(told, blocks, strict=True))
    alike = len({c.name.split(" (")[0] for c in times}) == 1 or all(
        w.isdigit() for c in times for w in words(c.name)[1:2]
    )
    if not (named or alike) and any(_other_scale(times[0].numbers, column.numbers) for column in times[1:]):
        return False
    step = float(np.nanmedian(np.abs(np.diff(times[0].numbers))))
    return named or alike or any(np.nanmax(gap) - np.nanmin(gap) > 0.5 * step for gap in between)


def _other_scale(first: np.ndarray, other: np.ndarray) -> bool:
    """Whether two times (N,) of the same rows last differently long and are the same but for a factor: those of the
    model and of the ship, between which the user chooses."""
    known = np.isfinite(first) & np.isfinite(other)
    if not np.array_equal(np.isfinite(first), np.isfinite(other)) or known.sum() < 3:
        return False
    one, two = first[known] - first[known][0], other[known] - other[known][0]
    factor = two[-1] / one[-1] if one[-1] else 1.0
    return bool(abs(factor - 1.0) > AS_LONG and np.abs(two - factor * one).max() < 1e-3 * abs(two[-1]))


def _parts(table: RawTable, talker: RawColumn) -> list[RawTable]:
    """A table for every talker, of the columns that it fills."""
    out = []
    assert talker.texts is not None
    kinds, codes = talker.texts.coded()
    for number, kind in enumerate(kinds):
        part = table.at(np.flatnonzero(codes == number), (c for c in table.columns if c is not talker), sheet=kind)
        filled = tuple(c for c in part.columns if c.first(1))
        if len(filled) > 1:
            out.append(replace(part, columns=filled))
    return faults_once(out) or [table]


def _long(table: RawTable, name: RawColumn, value: RawColumn) -> list[RawTable]:
    """A table for every named value (of every talker) of a table in long form."""
    unit, talker = _one(table, UNITS), _one(table, TALKERS)
    talker = None if talker is name else talker
    if unit is None and len(table.columns) == 4 and table.columns[3].name.startswith("column "):
        unit = table.columns[3]
    times = [c for c in table.columns if is_time(c.name) or c.known == "time"] or list(table.columns[:1])
    out = []
    for key, rows in _rows_of(name, talker):
        if len(rows) < 3 or not key[0]:
            continue
        said = unit.text(int(rows[0])) if unit is not None else ""
        short = last_part(key[0]) if "/" in key[0] else ""
        own = replace(value, name=key[0], unit=said or value.unit, called=short)
        out.append(table.at(rows, (*times, own), sheet=" ".join(part for part in (*key[1:], key[0]) if part)))
    return faults_once(out) or [table]


def _one(table: RawTable, wanted: frozenset[str]) -> RawColumn | None:
    return next((c for c in table.columns if joined(c.name) in wanted and c.texts is not None), None)


def _rows_of(name: RawColumn, talker: RawColumn | None) -> Iterator[tuple[tuple[str, str], np.ndarray]]:
    """((named value, talker), its rows) in the order of their first rows."""
    assert name.texts is not None
    names, codes = name.texts.coded()
    talkers, other = talker.texts.coded() if talker is not None and talker.texts is not None else ([""], 0 * codes)
    pairs, first = np.unique(codes * len(talkers) + other, return_index=True)
    for pair in pairs[np.argsort(first)].tolist():
        one, two = divmod(pair, len(talkers))
        yield (names[one], talkers[two]), np.flatnonzero((codes == one) & (other == two))
