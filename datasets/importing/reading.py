"""What a column states by itself: its header, letters in its cells, statements about it, the map, or the format."""

from __future__ import annotations

import math
import re
from dataclasses import replace
from functools import lru_cache

import numpy as np

from ..columns import ACCEPTED
from .cells import EITHER, GAPS
from .draft import NOT_USED
from .finding import WITH_SIDE, ColumnFinding, ask_numbers, ask_quantity, ask_scale, is_full_circle
from .headers import PERCENT, ColumnHeader, read_header, sign_stated, west_or_south
from .mapping import ColumnMap
from .names import Named, listed, named, words
from .quantities import RATE_OF, UNITS, is_unsigned, quantities, tidy, unit_of, vague_names, vocabulary, word_list
from .raw import RawColumn, RawTable

NAMELESS = re.compile(r"column \d+")
"""What the reader calls a column without a name."""
WITHOUT_NAME = ("without a name",)
"""Why a column of a file that names none may be anything."""
PRIMED = re.compile(r"^[A-Za-z_]{1,6}['\u2032]\s*$")
"""A name with the mark of a nondimensional quantity: r', v'."""
PREFIX = re.compile(r".*[./:]")
"""The group that a name begins with."""
FEWEST_OF_RECORD = 4
"""Columns named as those of a record, from which on their signs are a record's."""
OF_TIME = ("s", "sec", "seconds", "min", "h")
"""Units of a time, which no quantity has; a latitude may be in minutes."""
PULSES = ("us", "µs", "pwm")
"""Units of a servo's pulse."""


def stated(table: RawTable, column: RawColumn, given: ColumnMap | None, mapped: bool) -> ColumnFinding:
    """The finding of a column from what is said of it; `mapped`: there is a map, and it need not name the column."""
    base = ColumnFinding(table, column)
    # a number that stands for missing values
    found = _stated(base, given, mapped)
    missing = found.column.missing
    if not found.may_be or missing is None:
        return found
    count = int((found.column.cells.numbers == missing).sum())
    return replace(found, why=(*found.why, f"{missing:g} stands for a missing value ({count} cells)"))


def _stated(base: ColumnFinding, given: ColumnMap | None, mapped: bool) -> ColumnFinding:
    column = base.column
    if given is not None:
        if given.to == NOT_USED:
            return base.unused("the map says so")
        header = _from_header(base)
        if given.to == "?":
            return header
        unit = None if given.unit in ("?", None) else UNITS[given.unit]
        decided = replace(
            base, may_be=(given.to,), unit=unit, factor=given.factor, offset=given.offset, why=("the map says so",),
            sign=1 if given.sign == "?" else given.sign, signed=given.sign != "?", side=header.side,
            bounded=("quantity", *(("unit",) if unit else ()), *(("sign",) if given.sign != "?" else ())),
        )  # fmt: skip
        if unit is None and header.may_be == (given.to,):
            decided = replace(decided, unit=header.unit, factor=header.factor)
        if not decided.signed and header.may_be == (given.to,):
            decided = replace(decided, sign=header.sign, signed=header.signed)
        return decided
    if mapped:
        return base.unused(column.source if column.known == NOT_USED else "not in the map")
    if column.known:
        if column.known in (NOT_USED, "time"):
            return base.unused(column.source)
        unit = unit_of(column.unit, quantities()[column.known].dimension) or UNITS.get(column.unit)
        return replace(base, may_be=(column.known,), unit=unit, signed=True, side=column.side, why=(column.source,))
    return _from_header(base)


def _from_header(base: ColumnFinding) -> ColumnFinding:
    column = base.column
    if PRIMED.search(column.called or column.name):
        return base.unused("a prime marks it as nondimensional")
    header = read_header(_called(base.table, column), column.unit)
    if column.numeric and all(NAMELESS.fullmatch(one.name) for one in base.table.columns):
        text, every = f"What is {column.name!r}? The file names no columns.", tuple(quantities())
        return ask_quantity(replace(base, may_be=every, why=WITHOUT_NAME), text, every)
    name, suffix = _name(header)
    if name.extra and column.below:
        below = read_header(column.below, column.unit)
        own, text = _name(below)
        header, name, suffix = (below, own, text) if own.may_be and not own.extra else (header, name, suffix)
    for text in column.said if not name.may_be else ():  # `CH1: rudder angle` above the header
        label = read_header(text, column.unit)
        own, spelt = _name(label)
        if label.words and own.may_be and not own.extra:
            header, name, suffix = label, own, spelt
            break
    known = column.finite  # of a speed that is called v, not of a sway, to one side of 0 and far from it
    one_way = known.size > 0 and float(known.min()) > FAR_FROM_0 * float(known.max())
    if name.may_be == ("sway",) and len(header.words) == 1 and one_way:
        name = replace(name, may_be=vague_names()["speed"])
    base = replace(base, unread=header.unread)
    # the group that a name begins with, as in `ATTITUDE.roll` beside `ATTITUDE.yaw`, is that of a message
    prefix = PREFIX.match(column.name)
    grouped = prefix and any(c is not column and c.name.startswith(prefix[0]) for c in base.table.columns)
    group = words(prefix[0]) if prefix and grouped else ()
    name = replace(name, extra=tuple(word for word in name.extra if word not in group))
    if not name.may_be:
        return base.unused(name.why)
    empty = not np.isfinite(column.numbers).any() and not column.first(1)
    if empty:
        return base.unused("no value in the column")
    said = [read_header("", text) for text in column.said]
    positive = header.positive or next((s for text in column.said if (s := sign_stated(text)[0])), "")
    found = replace(base, may_be=name.may_be, why=(name.why,))
    found = _with_unit(found, header, suffix, said)
    if name.extra and found.may_be and (unit := _other_unit(found, name.extra)):
        return base.unused(f"{' or '.join(found.may_be)}? its unit {unit!r} is none of it")
    if name.extra and not found.may_be:  # the name is doubtful, and its unit is none of what it may mean
        return base.unused(Named().why)
    found = _with_sign(found, positive)
    if name.extra:
        shown = " ".join(name.extra)
        text = f"Is {column.name!r} a column of {' or '.join(found.may_be)}? {shown!r} in its name is not known."
        asked = ask_quantity(found, text, found.may_be)
        *others, question = asked.questions
        doubt = shown if len(found.may_be) == 1 else ""
        found = replace(asked, questions=(*others, replace(question, doubt=doubt)))
    if header.times != 1.0 and found.unit is not None:  # `x10`
        times, unit = header.times, found.unit.name
        text = f"{column.name!r} says x{times:g}: is one of the file {1.0 / times:g} {unit}, or 1?"
        found = ask_scale(found, text, unit, unit, (1.0 / times, 1.0), 1.0)
    texts = column.texts.unique() if column.style == "open" and column.texts is not None else []
    told = [text for text in texts if text.lower() not in GAPS]
    either = bool(told) and all(EITHER.fullmatch(text) and "," in text for text in told)
    return ask_numbers(found) if either else found


def _called(table: RawTable, column: RawColumn) -> str:
    """What a column is named by: its name, or, where it is only called `value` or `data`, its group, the one text
    that another column holds in every row, `Rudder Servo`, or the file."""
    if column.called or re.split(r"[./:]", column.name)[-1].lower() not in (*listed("values"), "signal"):
        return column.called or column.name
    group = table.label.rpartition("[")[2].rpartition("]")[0]
    texts = (c.texts.unique() for c in table.columns if c.texts is not None and not c.numeric)
    alone = [found[0] for own in texts if len(found := list(own)) == 1]
    told = (
        text
        for text in (*alone, table.file.rpartition(".")[0])
        if (name := named(words(text))).may_be and not name.extra
    )
    return group or next(told, column.name)


def _name(header: ColumnHeader) -> tuple[Named, str]:
    """(what the words say, the unit that their last ones spell)."""
    for head, text in header.suffixes:
        name = named(head)
        dimensions = {quantities()[q].dimension for q in name.may_be}
        rates = {quantities()[RATE_OF[q]].dimension for q in name.may_be if q in RATE_OF}
        fits = any(unit_of(text, dimension) for dimension in dimensions | rates)
        if name.may_be and (fits or text in PERCENT) and not name.extra:
            return name, text
    return named(header.words), ""


def _other_unit(found: ColumnFinding, extra: tuple[str, ...]) -> str:
    """The last unknown word of a doubtful name where it is a unit of none of what the name may mean, else ''."""
    last = extra[-1]
    dimensions = {
        quantities()[q].dimension for q in (*found.may_be, *(RATE_OF[q] for q in found.may_be if q in RATE_OF))
    }
    unit = unit_of(last) if len(last) > 1 and found.unit is None else None
    return last if unit is not None and not any(unit_of(last, dimension) for dimension in dimensions) else ""


def _with_unit(found: ColumnFinding, header: ColumnHeader, suffix: str, said: list[ColumnHeader]) -> ColumnFinding:
    """The finding with the unit that is stated, and what it leaves of the quantities that the name may mean."""
    headers = [header, *said]
    lettered = found.column.lettered
    named_unit = [word for word in header.words if word in ("rpm", "rps") and not header.units]
    texts = [*named_unit, *([suffix] if suffix else []), *([lettered.unit] if lettered and lettered.unit else [])]
    for quantity in [q for q in found.may_be] + [RATE_OF[q] for q in found.may_be if q in RATE_OF]:
        dimension = quantities()[quantity].dimension
        stated_units = [*(h.unit(dimension) for h in headers), *((unit_of(text, dimension), 1.0) for text in texts)]
        unit, factor = next((pair for pair in stated_units if pair[0] is not None), (None, 1.0))
        if unit is not None and dimension == "rotation" and unit.name == "rps" and suffix == "hz":
            unit, factor = UNITS["rps"], 1.0
        if unit is not None:
            same = tuple(q for q in found.may_be if quantities()[q].dimension == dimension) or (quantity,)
            return found.told("stated", f"unit {unit.name} stated", may_be=same, unit=unit, factor=factor)
    foreign = next((h.foreign for h in headers if h.foreign), "") or next((t for t in texts if t in PERCENT), "")
    pulses = (text for h in headers for text in h.units if text.lower() in PULSES and found.may_be[0] in WITH_SIDE)
    other = next((text for h in headers for text in h.units if unit_of(text) is not None), "") or next(pulses, "")
    place = found.may_be[0] in ("latitude", "longitude")
    timed = next((text for h in headers for text in h.units if tidy(text) in OF_TIME and not place), "")
    text = foreign or other or timed
    if not text:
        return found
    if found.may_be[0] in WITH_SIDE and len(found.may_be) == 1 and tidy(text) not in OF_TIME:  # per cent or volts
        return replace(found, why=(*found.why, f"unit {text!r} stated"), foreign=text)
    return found.unused(f"{' or '.join(found.may_be)}? its unit {text!r} is none of it")


def ask_foreign(found: ColumnFinding) -> ColumnFinding:
    """The finding of a rudder in a unit that is no angle, with the question for its scale."""
    text = found.foreign
    numbers = np.abs(found.column.finite)
    if text.lower() in PULSES and not numbers.max(initial=0.0) > 1.05:
        said = f"{found.column.name!r} is a share of the largest angle, -1 to 1: how many degrees are 1?"
        return ask_scale(found, said, "degrees at 1", "deg", (35.0, 45.0, 30.0), 1.0)
    if text.lower() in PULSES:
        said = f"{found.column.name!r} is a servo's pulse, 1500 us amidships: how many degrees are 400 us?"
        return ask_scale(found, said, "degrees at 1900 us", "deg", (35.0, 45.0, 30.0), 400.0, zero=1500.0)
    # a signal that keeps to one side of 0, which then need not be its middle
    known = found.column.numbers[np.isfinite(found.column.numbers)]
    low, high = (float(known.min()), float(known.max())) if known.size else (0.0, 0.0)
    if min(-low, high) < ONE_SIDED * max(-low, high):
        why = (
            f"in {text} and to one side of 0 only: what it is amidships is not stated; the map takes factor and offset"
        )
        return found.unused(why)
    if text.lower() in PERCENT:
        said = f"{found.column.name!r} is in per cent: how many degrees are 100 %?"
        return ask_scale(found, said, "degrees at 100 %", "deg", (35.0, 45.0, 30.0), 100.0)
    said = f"{found.column.name!r} is in {text}: how many degrees are one of it? 0 is taken as amidships."
    return ask_scale(found, said, "degrees of one unit of the file", "deg", (1.0,), 1.0)


ONE_SIDED = 0.1
"""Share of the largest value to one side that the other must reach for 0 to be the middle."""
FAR_FROM_0 = 0.3
"""Least number as a share of the largest from which on none is that of a velocity sideways."""
OPPOSITE = frozenset({"west", "westing", "south", "southing"})
"""Words of a position that counts to the west or to the south."""
TURNS = re.compile(r"\bccw\b|counter-?\s?clockwise|anti-?\s?clockwise")
"""What says that an angle counts as in mathematics."""
EAST = re.compile(r"(?<![a-z])(?:east|math[a-z]*|enu|ned)(?![a-z])", re.IGNORECASE)
"""What a header says of a heading that does not count from north."""


def _with_sign(found: ColumnFinding, positive: str) -> ColumnFinding:
    """The finding with the sign that its header, its letters or its name states."""
    lettered = found.column.lettered
    positive = positive or ("starboard" if lettered and lettered.positive == "starboard" else "")
    quantity = found.quantity
    if quantity in ("latitude", "longitude"):
        turned = west_or_south(found.column.name, found.column.unit)
        return replace(found, signed=True, sign=-1 if turned else 1)
    if quantity in ("north", "east") and OPPOSITE & set(words(found.column.called or found.column.name)):
        return found.told("stated", f"{found.column.name} counts the other way", signed=True, sign=-1)
    if quantity in WITH_SIDE:
        why = "angles count round the full circle: those beyond a half turn are the other side"
        found = replace(found, why=(*found.why, why)) if is_full_circle(found) else found
        return replace(found, signed=quantity == "rudder", side=positive)
    if quantity in ("yaw_rate", "sway"):
        positive = positive or {"nwu": "port", "ned": "starboard"}.get(frame_stated(found.table.notes), "")
    if positive and quantity in ("yaw_rate", "sway", "roll", "roll_rate"):
        sign = 1 if positive == "starboard" else -1
        return found.told("stated", f"positive to {positive} stated", signed=True, sign=sign)
    own = [column.name for column in found.table.columns if column.name in ACCEPTED]
    if found.column.name in own and len(own) >= FEWEST_OF_RECORD:  # as several of its table
        return found.told("stated", "the name is that of a record's column", signed=True)
    compass = quantity in ("heading", "heading_magnetic", "course_over_ground")
    mathematical = word_list("mathematical") & set(read_header(_called(found.table, found.column)).words)
    from_east = EAST.search(" ".join((_called(found.table, found.column), *found.column.said)))
    in_radians = found.unit is not None and found.unit.name != "deg"
    turns = TURNS.search(" ".join((_called(found.table, found.column), *found.column.said)).lower())
    if quantity == "heading" and (mathematical or from_east or in_radians or turns):
        told = _with_sense(found)
        if told.signed or from_east or positive != "starboard":
            return told
        return found.told("stated", "positive to starboard stated", signed=True)
    if compass and positive == "port":
        return found.told("stated", "positive to port stated", signed=True, sign=-1)
    return replace(found, signed=is_unsigned(quantity) or goes_ahead(found))


def _with_sense(found: ColumnFinding) -> ColumnFinding:
    """A heading with the way that it counts, where its name or what is said of it states that."""
    frame = frame_stated(found.table.notes)
    text = " ".join((_called(found.table, found.column), *found.column.said, frame)).lower().replace("_", " ")
    turns = TURNS.search(text)
    if turns and re.search(r"\bnorth\b", text) and not re.search(r"\beast\b", text):
        return found.told("stated", "counterclockwise from north stated", signed=True, sign=-1)
    mathematical = re.search(r"\benu\b|\bmath", text) or (turns and re.search(r"\beast\b", text))
    if mathematical and found.unit is not None:
        quarter = round(math.pi / 2.0 / found.unit.factor, 9)
        return found.told("stated", "counterclockwise from east stated", signed=True, sign=-1, offset=quarter)
    if re.search(r"(?<!counter)(?<!counter-)clockwise from north|\bned\b", text):
        return found.told("stated", "clockwise from north stated", signed=True)
    return found


@lru_cache(maxsize=64)
def frame_stated(notes: tuple[str, ...]) -> str:
    """The frame of all axes, `enu`, `ned` or `nwu`, that one of the lines above a table states; '' where none does."""
    for level in vocabulary()["frames"]:
        stated = {frame for frame, line in level.items() if any(re.search(line, note, re.I) for note in notes)}
        if stated:
            return stated.pop() if len(stated) == 1 else ""
    return ""


def goes_ahead(found: ColumnFinding) -> bool:
    """Whether a speed forward is positive in the main."""
    numbers = found.column.numbers
    return found.quantity == "surge" and bool(np.nanmedian(numbers) > 0.0)
