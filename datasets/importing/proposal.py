"""What is proposed of the columns of a table as a whole, and asked once: what those without a known name are, by how
they move together, and units that the file does not state and no channel tells."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace

import numpy as np

from ...models.errors import BadInput
from ..geometry import on_plane
from . import meanings, other_channels
from .by_motion import Assignment, Meaning, assignments, motion_of
from .clock import Form, guess_form
from .draft import NOT_USED, Answer, Question
from .evidence import together
from .finding import WITH_SIDE, ColumnFinding, line_of
from .log import RawLog
from .names import Named
from .quantities import UNITS, LogUnit, quantities
from .raw import RawTable
from .times import TableTime

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
    wrong_of = f"{table.label}/wrong column"
    wrong = log.answers.get(wrong_of)
    made = _proposals(log, table, able) if len(able) <= MOST_COLUMNS and wrong != SEVERAL else []
    if not made:
        return
    question = _question(table, able, made)
    key = said = key_of(question, log.answers)
    if key == NONE:
        meanings = {name: _said(meaning) for name, meaning in made[0].meanings.items()}
        told = ", ".join(f"{name} is {said}" for name, said in meanings.items())
        text = f"Which column is wrong? By how they move together {told}."
        columns = [Answer(n, f"{n} is not {m}", f"change the line of {n}") for n, m in meanings.items()]
        rest = Answer(SEVERAL, "several, or the time: ask for each column", "change the lines of these columns")
        question = Question(wrong_of, "columns", table.label, next(iter(meanings)), text, (*columns, rest))
        known = wrong in {f.column.name for f in able}
        said = key_of(question, log.answers) if known or not table.column(wrong or "") else wrong
        able = [f for f in able if f.column.name != wrong]
    if not said:
        log.proposals.append(question)
    chosen = made[int(key) - 1] if key and key != NONE else made[0]
    log.times[table.label] = time = chosen.time
    meant = {f.column.name: _meant(f, chosen.meanings.get(f.column.name), bool(said)) for f in able}
    log.findings = [
        meant.get(f.column.name, f) if f.table is table else f
        for f in log.findings
        if f.table is not table or f.column.name not in time.columns
    ]


def key_of(question: Question, answers: Mapping[str, str]) -> str | None:
    """The key that was answered; BadInput where it is none of the question's."""
    key = answers.get(question.id)
    if key is not None and question.answer(key) is None:
        keys = ", ".join(answer.key for answer in question.answers)
        raise BadInput(f"{key!r} is no answer to {question.id!r}", hint=f"give one of: {keys}")
    return key


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
        # columns whose meaning is known, in SI units; positions of a globe on a plane
        values, known = dict[str, np.ndarray](), dict[str, Meaning]()
        for own in (f for f in log.findings if f.table is table and f.quantity is not None):
            unit = SI.get(own.dimension)
            if own.unit is not None and unit and own.signed and not own.questions:
                values[own.column.name] = own.values()
                known[own.column.name] = Meaning(str(own.quantity), unit, 1, "")
        for (_, latitude), (_, longitude) in log.beside("latitude", "longitude"):
            shared = together(latitude, longitude)
            if shared is not None and np.abs(shared[1]).max() <= np.pi / 2.0 and latitude.clock == table.clock:
                for name, column in zip(("north", "east"), on_plane(shared[1], shared[2])[:2], strict=True):
                    values[f" {name}"] = np.interp(found[0], shared[0], column)
                    known[f" {name}"] = Meaning(name, "m", 1, "")
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


# ------------------------------------------------------------------------------------------------ question


def _question(table: RawTable, able: Sequence[ColumnFinding], made: Sequence[Assignment]) -> Question:
    """The question which of the proposals is right; the answers say otherwise than the first, which the draft holds."""
    first, *others = made
    mine = first.meanings
    clock = [f"{first.time.columns[0]} is the time ({first.time.form})"] if first.time.sure == "other channel" else []
    told = ", ".join([*clock, *(f"{name} is {_said(m)}" for name, m in mine.items())])
    text = f"No name tells these columns. By how they move together {told}. Is this right?"
    answers = [Answer("1", "yes, all of it", "nothing more: the draft says it")]
    for number, its in enumerate((other.meanings for other in others), start=2):
        changed = [f"{n} is {_said(m)}" for n, m in its.items() if n not in mine or _said(mine[n]) != _said(m)]
        dropped = [f"{n} is not used" for n in mine if n not in its]
        lines = [
            line_of(_meant(f, its.get(name), True), **({} if name in its else {"to": NOT_USED}))
            for f in able
            if mine.get(name := f.column.name) != its.get(name)
        ]
        said = " and ".join(lines) or "nothing more: the draft says it"
        answers.append(Answer(str(number), f"no, but {', '.join([*changed, *dropped])}", said))
    rest = Answer(NONE, "no", "change the lines of these columns")
    return Question(columns_question(table.label), "columns", table.label, next(iter(mine)), text, (*answers, rest))


def columns_question(label: str) -> str:
    """Id of the question what the columns of a table are."""
    return f"{label}/columns"


def _said(meaning: Meaning) -> str:
    sign = ", with the opposite sign" if meaning.sign < 0 else ""
    if meaning.quantity == "heading" and meaning.sign < 0:
        sign = f", counterclockwise from {'east' if meaning.offset else 'north'}"
    return f"{meaning.quantity.replace('_', ' ')} [{meaning.unit}{sign}]"


# ---- Units.
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
    for table, labels in _together(log, tables):
        places = [i for i, found in enumerate(log.findings) if found.table.label in labels and is_open(found)]
        identifier = f"{table.label}/{len(places)} units"  # with more columns another question
        if len(places) < 2 or log.answers.get(identifier) == NONE:
            continue
        before = list(log.findings)
        _take_likely(log, labels, places)
        likely = {i: log.findings[i] for i in places if log.findings[i].unit is not None}
        log.findings = before
        units = ", ".join(_with_unit(found) for found in likely.values())
        text = f"The file does not state these units. By size and how the columns move together {units}. Is this right?"
        answers = (
            Answer("1", "yes, all of it", "nothing more: the draft says it"),
            Answer(NONE, "no: ask for each column", "change the units of these columns"),
        )
        first = before[next(iter(likely))].column.name
        place = before[next(iter(likely))].table.label
        question = Question(identifier, "columns", place, first, text, answers)
        sure = key_of(question, log.answers) is not None
        why = "as answered" if sure else "its unit is likely, by its size and how the columns move together"
        for i, found in likely.items():
            log.findings[i] = replace(
                before[i], unit=found.unit, factor=found.factor, sure="stated" if sure else "guess",
                why=(*before[i].why, why), bounded=(*before[i].bounded, "unit"),
            )  # fmt: skip
        if not sure:
            log.proposals.append(question)


def _together(log: RawLog, tables: Sequence[RawTable]) -> Iterator[tuple[RawTable, set[str]]]:
    """(first table, labels) of tables that are asked together: each alone, or those of a file that have one open column
    each."""
    groups: dict[str, list[RawTable]] = {}
    for table in tables:
        count = sum(found.table is table and is_open(found) for found in log.findings)
        groups.setdefault(table.file if count == 1 else table.label, []).append(table)
    yield from ((own[0], {table.label for table in own}) for own in groups.values())


def _with_unit(found: ColumnFinding) -> str:
    """What a column may be, and its unit."""
    assert found.unit is not None
    unit = found.unit.name if found.factor == 1.0 else f"{found.factor:g} {found.unit.name}"
    return f"{found.column.name} is {' or '.join(quantity.replace('_', ' ') for quantity in found.may_be)} [{unit}]"


def is_open(found: ColumnFinding) -> bool:
    """Whether nothing says the unit of a column whose dimension is known, and it is not all zero; a rudder beyond all
    angles is in another measure, which is asked alone."""
    dimensions = {quantities()[quantity].dimension for quantity in found.may_be}
    told = found.unit is not None or found.foreign or found.unread or found.questions
    known = found.column.finite
    beyond = (
        bool(set(found.may_be) & set(WITH_SIDE)) and other_channels.size_of(found) > other_channels.LARGEST_RUDDER_DEG
    )
    tenths = bool(set(found.may_be) & set(other_channels.WRAPPING)) and other_channels.in_tenths(found)
    return len(dimensions) == 1 and not (told or beyond or tenths) and dimensions != {"force"} and bool(np.any(known))


def _take_likely(log: RawLog, labels: set[str], places: Sequence[int]) -> None:
    """Put the likely units into a log: lengths in metres, then what these and other columns tell, then by size."""
    for dimension in ("length", "angle", "angular rate", "speed", "rotation"):
        for i in places:
            found = log.findings[i]
            # the unit of a rudder that is open tells that of its order
            rudders = [f for f in log.findings if f.table.label in labels and f.quantity == "rudder" and f.unit is None]
            waits = found.quantity == "rudder_command" and bool(rudders)
            if found.unit is None and found.dimension == dimension and not waits:
                log.findings[i] = replace(found, unit=_by_size(log, labels, found))
        for _ in range(PASSES):
            for i, found in enumerate(log.findings):
                if found.table.label in labels and found.may_be:
                    log.findings[i] = other_channels.unit_by_channel(log, meanings.settle(log, found))


def _by_size(log: RawLog, labels: set[str], found: ColumnFinding) -> LogUnit:
    """The likely unit of a column: that of the others of its tables, or by its size."""
    size, quantity = other_channels.size_of(found), found.may_be[0]
    angles = [f for f in log.findings if f.table.label in labels and f.may_be and f.may_be[0] in ANGLES]
    stated = {f.unit.name for f in angles if f.unit is not None}
    most = [1.02 * other_channels.LARGEST_RAD.get(f.may_be[0], other_channels.FULL_TURN) for f in angles]
    small = all(other_channels.size_of(f) <= largest for f, largest in zip(angles, most, strict=True))
    in_radians = stated == {"rad"} or (not stated and small)
    if found.dimension == "angle":
        largest = other_channels.LARGEST_RAD.get(quantity, other_channels.UNWRAPPED)
        return UNITS["rad" if in_radians and size <= 1.02 * largest else "deg"]
    if found.dimension == "angular rate":
        return UNITS["rad/s" if in_radians else "deg/s" if size <= FASTEST_TURN_DEG_S else "deg/min"]
    if found.dimension == "speed":
        return UNITS["m/s" if in_radians or quantity not in OF_INSTRUMENTS else "kn"]
    if found.dimension == "length":  # millimetres where it moves faster than any craft if it is in metres
        series = log.series(found, raw=True)
        known = series is not None and bool(np.isfinite(series.time).any())
        lasts, moved = (np.nanmax(x) - np.nanmin(x) for x in (series.time, series.values)) if known else (0.0, 0.0)
        return UNITS["mm" if moved > other_channels.FASTEST_M_S * lasts else "m"]
    return UNITS["rps" if size <= MOST_RPS else "rpm"]
