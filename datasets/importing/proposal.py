"""What the columns without a known name are: proposed as a whole by how they move together, and asked once."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from ...models.errors import BadInput
from .by_motion import Assignment, Meaning, assignments, motion_of
from .clock import Form, guess_form
from .draft import NOT_USED, Answer, Question
from .evidence import together
from .finding import ColumnFinding, line_of
from .geodesy import on_plane
from .names import Named
from .quantities import quantities
from .times import TableTime
from .units import UNITS

if TYPE_CHECKING:
    from .log import RawLog
    from .raw import RawTable

NONE, SEVERAL = "none", "several"
"""Keys of the answers that no proposal is right, and that more than one column is wrong."""
MOST, MOST_COLUMNS = 3, 40
"""Proposals that are shown; columns beyond which none is made."""
SI = {"angle": "rad", "angular rate": "rad/s", "speed": "m/s", "length": "m"}
NEEDED = (("rudder", "rudder_command"), ("heading", "yaw_rate", "heading_magnetic"))
"""Quantities of which a record needs one each."""


@dataclass(frozen=True)
class ColumnAssignment:
    """What some columns of a table are, and the column and form of its time."""

    assignment: Assignment
    time: TableTime


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


def _take(log: RawLog, table: RawTable, able: Sequence[ColumnFinding], chosen: ColumnAssignment, sure: bool) -> None:
    """Put what a proposal says into the log: the time of the table, and what its open columns are."""
    log.times[table.label] = chosen.time
    log.forget_times(table.label)
    meant = {f.column.name: _meant(f, chosen.assignment.meanings.get(f.column.name), sure) for f in able}
    log.findings = [
        meant.get(f.column.name, f) if f.table is table else f
        for f in log.findings
        if f.table is not table or f.column.name not in chosen.time.columns
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


def _proposals(log: RawLog, table: RawTable, able: Sequence[ColumnFinding]) -> list[ColumnAssignment]:
    """What the columns may be, with the time that it needs: the likeliest first."""
    made: list[ColumnAssignment] = []
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
        made += [ColumnAssignment(one, time) for one in whole if len(one.meanings) > 1]
    made.sort(key=lambda proposal: -proposal.assignment.worth)
    alike = [p for p in made if p.time == made[0].time][:MOST]
    turned = made[0].assignment.mirrored if made and not senses else []
    return [*alike, *(replace(made[0], assignment=assignment) for assignment in turned)]


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


def _question(table: RawTable, able: Sequence[ColumnFinding], made: Sequence[ColumnAssignment]) -> Question:
    """The question which of the proposals is right."""
    first = made[0]
    clock = [f"{first.time.columns[0]} is the time ({first.time.form})"] if first.time.sure == "other channel" else []
    told = ", ".join([*clock, *(f"{name} is {_said(m)}" for name, m in first.assignment.meanings.items())])
    text = f"No name tells these columns. By how they move together {told}. Is this right?"
    answers = [
        Answer(str(i), "yes, all of it" if i == 1 else f"no, but {_difference(first, one)}", _lines(able, first, one))
        for i, one in enumerate(made, start=1)
    ]
    rest = Answer(NONE, "no", "change the lines of these columns")
    at = next(iter(first.assignment.meanings))
    return Question(question_of(table.label), "columns", table.label, at, text, (*answers, rest))


def _question_of_wrong(table: RawTable, first: ColumnAssignment) -> Question:
    """The question which column of the proposal is not what it is proposed to be."""
    meanings = first.assignment.meanings
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


def _difference(first: ColumnAssignment, other: ColumnAssignment) -> str:
    """What another proposal says otherwise."""
    mine, its = first.assignment.meanings, other.assignment.meanings
    changed = [f"{n} is {_said(m)}" for n, m in its.items() if n not in mine or _said(mine[n]) != _said(m)]
    dropped = [f"{n} is not used" for n in mine if n not in its]
    return ", ".join([*changed, *dropped])


def _lines(able: Sequence[ColumnFinding], first: ColumnAssignment, made: ColumnAssignment) -> str:
    """The lines of the map that say what a proposal says otherwise than the first, which the draft holds."""
    mine, its = first.assignment.meanings, made.assignment.meanings
    changed = [f for f in able if mine.get(f.column.name) != its.get(f.column.name)]
    lines = [
        line_of(_meant(f, its.get(f.column.name), True), **({} if f.column.name in its else {"to": NOT_USED}))
        for f in changed
    ]
    return " and ".join(lines) or "nothing more: the draft says it"
