"""What is proposed of the columns of a table as a whole, and asked once: what those without a known name are, by how
they move together, and units that the file does not state and no channel tells."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace

import numpy as np

from ...models.errors import BadInput
from . import meanings, units_told
from .by_motion import Assignment, Meaning, assignments, motion_of
from .clock import Form, guess_form
from .draft import NOT_USED, Answer, Question
from .evidence import together
from .finding import WITH_SIDE, ColumnFinding, line_of
from .geodesy import on_plane
from .log import RawLog
from .names import Named
from .quantities import quantities
from .raw import RawTable
from .times import TableTime
from .units import UNITS, LogUnit

NONE, SEVERAL = "none", "several"
"""Keys of the answers that no proposal is right, and that more than one column is wrong."""
MOST, MOST_COLUMNS = 3, 40
"""Proposals that are shown; columns beyond which none is made."""
SI = {"angle": "rad", "angular rate": "rad/s", "speed": "m/s", "length": "m"}
NEEDED = (("rudder", "rudder_command"), ("heading", "yaw_rate", "heading_magnetic"))
"""Quantities of which a record needs one each."""
TELL_SENSE = {"heading", "yaw_rate", "sway", "north", "east", "velocity_north", "velocity_east", "course_over_ground"}
"""Quantities of which one that is known tells to which side the others are positive."""


def propose(log: RawLog, tables: Sequence[RawTable]) -> None:
    """Take the columns that no name tells for what they are by their motion, with a question for each table that says
    all of it; those of an answer surely.  Where none is right one more question says which column is wrong: the others
    are taken, and nothing is where several are wrong.

    A single column is left to the question which one is the rudder.
    """
    told = {quantity for f in log.findings if not _is_open(f) for quantity in f.may_be}
    missing = any(told.isdisjoint(wanted) for wanted in NEEDED)
    for table in tables:
        own = [f for f in log.findings if f.table is table]
        able = [f for f in own if _is_open(f)]
        nameless = bool(able) and len(able) == sum(f.column.numeric for f in own)
        if len(able) > 1 and (nameless or missing):
            _propose(log, table, able)


def _is_open(found: ColumnFinding) -> bool:
    """Whether no name says what a column of numbers is."""
    numbers = found.column.numbers if found.column.numeric else np.zeros(0)
    unknown = (not found.may_be and found.why == (Named().why,)) or len(found.may_be) == len(quantities())
    return unknown and not found.bounded and bool(np.isfinite(numbers).sum() > 1)


def _propose(log: RawLog, table: RawTable, able: Sequence[ColumnFinding]) -> None:
    wrong = log.answers.get(_id_of_wrong(table))
    made = _proposals(log, table, able) if len(able) <= MOST_COLUMNS and wrong != SEVERAL else []
    if not made:
        return
    question = _question(table, able, made)
    key = said = key_of(question, log.answers)
    if key == NONE:
        question, known = _question_of_wrong(table, made[0]), wrong in {f.column.name for f in able}
        said = key_of(question, log.answers) if known or not table.column(wrong or "") else wrong
        able = [f for f in able if f.column.name != wrong]
    if not said:
        log.proposals.append(question)
    chosen = made[int(key) - 1] if key and key != NONE else made[0]
    _take(log, table, able, chosen, bool(said))


def key_of(question: Question, answers: Mapping[str, str]) -> str | None:
    """The key that was answered; BadInput where it is none of the question's."""
    key = answers.get(question.id)
    if key is not None and question.answer(key) is None:
        keys = ", ".join(answer.key for answer in question.answers)
        raise BadInput(f"{key!r} is no answer to {question.id!r}", hint=f"give one of: {keys}")
    return key


def _take(log: RawLog, table: RawTable, able: Sequence[ColumnFinding], chosen: Assignment, sure: bool) -> None:
    """Put what a proposal says into the log: the time of the table, and what its open columns are."""
    log.times[table.label] = time = chosen.time
    log.forget_times(table.label)
    meant = {f.column.name: _meant(f, chosen.meanings.get(f.column.name), sure) for f in able}
    log.findings = [
        meant.get(f.column.name, f) if f.table is table else f
        for f in log.findings
        if f.table is not table or f.column.name not in time.columns
    ]


def question_of(label: str) -> str:
    """Id of the question what the columns of a table are."""
    return f"{label}/columns"


def _id_of_wrong(table: RawTable) -> str:
    """Id of the question which column is not what it is proposed to be."""
    return f"{table.label}/wrong column"


def _meant(found: ColumnFinding, meaning: Meaning | None, sure: bool) -> ColumnFinding:
    """The finding of a column with what it means."""
    if meaning is None:
        return found.unused("no other column tells what it is")
    return replace(
        found, may_be=(meaning.quantity,), unit=UNITS[meaning.unit], factor=1.0, offset=meaning.offset,
        sign=meaning.sign, signed=True, sure="other channel" if sure else "guess", why=(meaning.why,), questions=(),
        bounded=("quantity", "unit", "sign"),
    )  # fmt: skip


# ------------------------------------------------------------------------------------------------ proposals


def _proposals(log: RawLog, table: RawTable, able: Sequence[ColumnFinding]) -> list[Assignment]:
    """What the columns may be, with the time that it needs: the likeliest first."""
    made: list[Assignment] = []
    senses = set[str]()
    for time in _times(log, table, able):
        found = time.seconds(table)
        if found is None:
            continue
        values, known = _known(log, table, found[0])
        senses |= {meaning.quantity for meaning in known.values()} & TELL_SENSE
        values |= {f.column.name: f.column.numbers for f in able if f.column.name not in time.columns}
        motion = motion_of(found[0], values, known)
        whole = assignments(motion) if motion is not None else []
        made += [replace(one, time=time) for one in whole if len(one.meanings) > 1]
    made.sort(key=lambda proposal: -proposal.worth)
    alike = [p for p in made if p.time == made[0].time][:MOST]
    turned = made[0].mirrored if made and not senses else []
    return [*alike, *turned]


def _times(log: RawLog, table: RawTable, able: Sequence[ColumnFinding]) -> Iterator[TableTime]:
    """The time of a table, or what may be it where no name tells: columns that rise evenly, in each form."""
    stated = log.times[table.label]
    if stated.columns or stated.form == "rows":
        yield stated
        return
    rising = [(_unevenness(f.column.numbers), place, f) for place, f in enumerate(able)]
    for _, _, found in sorted((entry for entry in rising if entry[0] < 0.02), key=lambda entry: entry[:2])[:2]:
        guess = guess_form(found.column, "")
        forms: tuple[Form, ...] = guess.forms if guess is not None else ()
        for form in forms:
            why = f"rises evenly; {form} by how the other columns move"
            yield TableTime((found.column.name,), form, form, None, "other channel", why)


def _unevenness(numbers: np.ndarray) -> float:
    """How far numbers (N,) are from rising by equal steps, as a share of their range; inf where they fall."""
    known = numbers[np.isfinite(numbers)]
    if known.size < 30 or np.mean(np.diff(known) >= 0.0) < 0.99 or np.ptp(known) == 0.0:
        return np.inf
    rows = np.arange(known.size, dtype=float)
    slope, start = np.polyfit(rows, known, 1)
    return float(np.std(known - slope * rows - start) / np.ptp(known))


def _known(log: RawLog, table: RawTable, time: np.ndarray) -> tuple[dict[str, np.ndarray], dict[str, Meaning]]:
    """Columns of a table whose meaning is known, in SI units: (values, meanings); positions of a globe on a plane."""
    values: dict[str, np.ndarray] = {}
    known: dict[str, Meaning] = {}
    for found in log.findings:
        unit = SI.get(found.dimension) if found.quantity is not None else None
        if found.table is table and found.unit is not None and unit and found.signed and not found.questions:
            values[found.column.name] = found.values()
            known[found.column.name] = Meaning(str(found.quantity), unit, 1, "")
    for (_, latitude), (_, longitude) in log.beside("latitude", "longitude"):
        shared = together(latitude, longitude)
        if shared is not None and np.abs(shared[1]).max() <= np.pi / 2.0 and latitude.clock == table.clock:
            north, east, _ = on_plane(shared[1], shared[2])
            for name, column in (("north", north), ("east", east)):
                values[f" {name}"] = np.interp(time, shared[0], column)
                known[f" {name}"] = Meaning(name, "m", 1, "")
    return values, known


# ------------------------------------------------------------------------------------------------ question


def _question(table: RawTable, able: Sequence[ColumnFinding], made: Sequence[Assignment]) -> Question:
    """The question which of the proposals is right."""
    first = made[0]
    clock = [f"{first.time.columns[0]} is the time ({first.time.form})"] if first.time.sure == "other channel" else []
    told = ", ".join([*clock, *(f"{name} is {_said(m)}" for name, m in first.meanings.items())])
    text = f"No name tells these columns. By how they move together {told}. Is this right?"
    answers = [
        Answer(str(i), "yes, all of it" if i == 1 else f"no, but {_difference(first, one)}", _lines(able, first, one))
        for i, one in enumerate(made, start=1)
    ]
    rest = Answer(NONE, "no", "change the lines of these columns")
    at = next(iter(first.meanings))
    return Question(question_of(table.label), "columns", table.label, at, text, (*answers, rest))


def _question_of_wrong(table: RawTable, first: Assignment) -> Question:
    """The question which column of the proposal is not what it is proposed to be."""
    meanings = first.meanings
    told = ", ".join(f"{name} is {_said(m)}" for name, m in meanings.items())
    columns = [Answer(name, f"{name} is not {_said(m)}", f"change the line of {name}") for name, m in meanings.items()]
    rest = Answer(SEVERAL, "several, or the time: ask for each column", "change the lines of these columns")
    text = f"Which column is wrong? By how they move together {told}."
    return Question(_id_of_wrong(table), "columns", table.label, next(iter(meanings)), text, (*columns, rest))


def _said(meaning: Meaning) -> str:
    sign = ", with the opposite sign" if meaning.sign < 0 else ""
    if meaning.quantity == "heading" and meaning.sign < 0:
        sign = f", counterclockwise from {'east' if meaning.offset else 'north'}"
    return f"{meaning.quantity.replace('_', ' ')} [{meaning.unit}{sign}]"


def _difference(first: Assignment, other: Assignment) -> str:
    """What another proposal says otherwise."""
    mine, its = first.meanings, other.meanings
    changed = [f"{n} is {_said(m)}" for n, m in its.items() if n not in mine or _said(mine[n]) != _said(m)]
    dropped = [f"{n} is not used" for n in mine if n not in its]
    return ", ".join([*changed, *dropped])


def _lines(able: Sequence[ColumnFinding], first: Assignment, made: Assignment) -> str:
    """The lines of the map that say what a proposal says otherwise than the first, which the draft holds."""
    mine, its = first.meanings, made.meanings
    changed = [f for f in able if mine.get(f.column.name) != its.get(f.column.name)]
    lines = [
        line_of(_meant(f, its.get(f.column.name), True), **({} if f.column.name in its else {"to": NOT_USED}))
        for f in changed
    ]
    return " and ".join(lines) or "nothing more: the draft says it"


# ---- Units.

YES = "1"
"""Key of the answer that all of it is right."""
PASSES = 3
"""How often columns are compared: one that is told may tell the next."""
FASTEST_TURN_DEG_S = 5.0
"""Largest number of a yaw rate in degrees a second; one beside degrees that is larger counts minutes."""
OF_INSTRUMENTS = ("speed_over_ground", "speed_through_water", "wind_speed")
"""Speeds that instruments on board show in knots."""
ANGLES = ("heading", "heading_magnetic", "course_over_ground", "rudder", "rudder_command")
"""Angles that a file has in one unit."""
MOST_RPS = 15.0
"""Largest number of a propeller's revolutions a second."""


def propose_units(log: RawLog, tables: Sequence[RawTable]) -> None:
    """Take the likely units of the columns of each table that have none, with one question for all of them; none where
    it is answered that they are not right, or only one is open."""
    for table in tables:
        places = [i for i, found in enumerate(log.findings) if found.table is table and is_open(found)]
        identifier = f"{table.label}/{len(places)} units"  # with more columns another question
        if len(places) < 2 or log.answers.get(identifier) == NONE:
            continue
        before = list(log.findings)
        _take_likely(log, table, places)
        likely = {i: log.findings[i] for i in places if log.findings[i].unit is not None}
        question = _question_of_units(identifier, list(likely.values()))
        sure = key_of(question, log.answers) is not None
        log.findings = before
        for i, found in likely.items():
            log.findings[i] = _with_likely_unit(before[i], found, sure)
        if not sure:
            log.proposals.append(question)


def is_open(found: ColumnFinding) -> bool:
    """Whether nothing says the unit of a column whose dimension is known, and it is not all zero; a rudder beyond all
    angles is in another measure, which is asked alone."""
    dimensions = {quantities()[quantity].dimension for quantity in found.may_be}
    told = found.unit is not None or found.foreign or found.unread or found.questions
    known = found.column.finite
    beyond = bool(set(found.may_be) & set(WITH_SIDE)) and units_told.size_of(found) > units_told.LARGEST_RUDDER_DEG
    tenths = bool(set(found.may_be) & set(units_told.WRAPPING)) and units_told.in_tenths(found)
    return len(dimensions) == 1 and not (told or beyond or tenths) and dimensions != {"force"} and bool(np.any(known))


def _take_likely(log: RawLog, table: RawTable, places: Sequence[int]) -> None:
    """Put the likely units into a log: lengths in metres, then what these and other columns tell, then by size."""
    for dimension in ("length", "angle", "angular rate", "speed", "rotation"):
        for i in places:
            found = log.findings[i]
            # the unit of a rudder that is open tells that of its order
            rudders = [f for f in log.findings if f.table is table and f.quantity == "rudder" and f.unit is None]
            waits = found.quantity == "rudder_command" and bool(rudders)
            if found.unit is None and found.dimension == dimension and not waits:
                log.findings[i] = replace(found, unit=_by_size(log, table, found))
        for _ in range(PASSES):
            for i, found in enumerate(log.findings):
                if found.table is table and found.may_be:
                    log.findings[i] = units_told.by_channel(log, meanings.settle(log, found))


def _by_size(log: RawLog, table: RawTable, found: ColumnFinding) -> LogUnit:
    """The likely unit of a column: that of the others of its table, or by its size."""
    size, in_radians = units_told.size_of(found), _in_radians(log, table)
    if found.dimension == "angle":
        most = units_told.LARGEST_RAD.get(found.may_be[0], units_told.UNWRAPPED)
        return UNITS["rad" if in_radians and size <= 1.02 * most else "deg"]
    if found.dimension == "angular rate":
        return UNITS["rad/s" if in_radians else "deg/s" if size <= FASTEST_TURN_DEG_S else "deg/min"]
    if found.dimension == "speed":
        return UNITS["m/s" if in_radians or found.may_be[0] not in OF_INSTRUMENTS else "kn"]
    if found.dimension == "length":
        return UNITS["mm" if _is_fast(log, table, found) else "m"]
    return UNITS["rps" if size <= MOST_RPS else "rpm"]


def _in_radians(log: RawLog, table: RawTable) -> bool:
    """Whether all angles of a table are in radians, or may be."""
    angles = [f for f in log.findings if f.table is table and f.may_be and f.may_be[0] in ANGLES]
    stated = {f.unit.name for f in angles if f.unit is not None}
    most = [1.02 * units_told.LARGEST_RAD.get(f.may_be[0], units_told.FULL_TURN) for f in angles]
    small = all(units_told.size_of(f) <= largest for f, largest in zip(angles, most, strict=True))
    return stated == {"rad"} or (not stated and small)


def _is_fast(log: RawLog, table: RawTable, found: ColumnFinding) -> bool:
    """Whether a position moves faster than any craft if it is in metres."""
    series = log.series(found, raw=True)
    if series is None or not np.isfinite(series.time).any():
        return False
    lasts = float(np.nanmax(series.time) - np.nanmin(series.time))
    moved = float(np.nanmax(series.values) - np.nanmin(series.values))
    return moved > units_told.FASTEST_M_S * lasts


def _with_likely_unit(found: ColumnFinding, likely: ColumnFinding, sure: bool) -> ColumnFinding:
    """The finding of a column with its likely unit."""
    why = "as answered" if sure else "its unit is likely, by its size and how the columns move together"
    return replace(
        found, unit=likely.unit, factor=likely.factor, sure="stated" if sure else "guess", why=(*found.why, why),
        bounded=(*found.bounded, "unit"),
    )  # fmt: skip


def _question_of_units(identifier: str, likely: Sequence[ColumnFinding]) -> Question:
    told = ", ".join(f"{f.column.name} is {_said_of_unit(f)}" for f in likely)
    text = f"The file does not state these units. By size and how the columns move together {told}. Is this right?"
    answers = (
        Answer(YES, "yes, all of it", "nothing more: the draft says it"),
        Answer(NONE, "no: ask for each column", "change the units of these columns"),
    )
    first = likely[0]
    return Question(identifier, "columns", first.table.label, first.column.name, text, answers)


def _said_of_unit(found: ColumnFinding) -> str:
    """What a column may be, and its unit."""
    assert found.unit is not None
    unit = found.unit.name if found.factor == 1.0 else f"{found.factor:g} {found.unit.name}"
    return f"{' or '.join(quantity.replace('_', ' ') for quantity in found.may_be)} [{unit}]"
