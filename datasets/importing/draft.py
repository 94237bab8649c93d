"""The draft of an import: every column of a log, what it was taken for, why, and the questions that are open."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass, replace
from typing import TYPE_CHECKING, Any, Literal, TypeAlias

if TYPE_CHECKING:
    from .finding import ColumnFinding
    from .raw import RawTable

Sure: TypeAlias = Literal["stated", "other channel", "physics", "guess"]
"""How surely a column is known: the file, its format, the map or an answer states it; another channel agrees; nothing
else is physically possible; or it is a guess, and then there is a question."""
About: TypeAlias = Literal["quantity", "unit", "sign", "time", "numbers", "rudder side", "file", "columns"]
FEWEST_OF_RUN = 4
"""Columns from which on tables of one file with equal headers are runs of the same logger."""
NOT_USED, TIME = "not used", "time"
"""What a column is that becomes no channel, and one of the time, whose unit is its form."""


@dataclass(frozen=True)
class Answer:
    """A possible answer: its key, what it means, and the line that says the same in the map."""

    key: str
    text: str
    line: str


@dataclass(frozen=True)
class Question:
    """Something that no one stated.

    id : is the same at every draft of the same files;  about : what is asked;  table, column : where ('' : the whole
    log or table);  answers : likeliest first;  number : what a number means that may be given instead of the key of an
    answer, '' where none may;  doubt : words of a name that are not known: one answer is that of all columns with them;
    without : key of the answer that leaves the column out, where a record is right without it, '' where it is not.
    """

    id: str
    about: About
    table: str
    column: str
    text: str
    answers: tuple[Answer, ...]
    number: str = ""
    doubt: str = ""
    without: str = ""

    def answer(self, key: str) -> Answer | None:
        """The answer of that key, if there is one."""
        return next((answer for answer in self.answers if answer.key == key), None)


@dataclass(frozen=True)
class DraftColumn:
    """A column of a log.

    table, column : file (and sheet), and the name in it.
    quantity : one of `QUANTITIES`, 'time', or 'not used'.
    unit : of the numbers in the file, '' where there is none or it is open.
    sign : the sign convention in words, '' where there is none or it is open.
    why : what says so, or why it is not used.
    sure : how surely; see `Sure`.
    questions : what is open, empty where nothing is.
    smallest, largest : number in the file, nan where there is none.
    samples : some cells, as they stand in the file.
    """

    table: str
    column: str
    quantity: str
    unit: str
    sign: str
    why: str
    sure: Sure
    questions: tuple[Question, ...]
    smallest: float
    largest: float
    samples: tuple[str, ...]

    @property
    def used(self) -> bool:
        """Whether the column becomes a channel, or the time."""
        return self.quantity != NOT_USED


def plain(columns: Sequence[DraftColumn]) -> list[dict[str, Any]]:
    """Columns as plain data for JSON: null where a number is none."""
    rows = [asdict(column) for column in columns]
    return [row | {k: None if row[k] != row[k] else row[k] for k in ("smallest", "largest")} for row in rows]


# ---- One question for several columns: of files with equal headers, and of names with the same doubtful word.


def for_equal_headers(tables: Sequence[RawTable], answers: Mapping[str, str]) -> dict[str, str]:
    """The answers, each also for the same column of tables with equal headers."""
    out = dict(answers)
    for group in _equal(tables):
        for table in group:
            for key in [key for key in answers if key.startswith(f"{table.label}/")]:
                rest = key.removeprefix(table.label)
                out |= {f"{other.label}{rest}": answers[key] for other in group if other.label + rest not in answers}
    return out


def for_equal_doubts(findings: Sequence[ColumnFinding], answers: Mapping[str, str]) -> dict[str, str]:
    """The answers, each also for the columns whose names raise the same doubt."""
    out = dict(answers)
    asked = [question for found in findings for question in found.questions if question.doubt]
    for first in (question for question in asked if question.id in answers):
        for other in (q for q in asked if q.doubt == first.doubt and q.id not in answers):
            out[other.id] = NOT_USED if answers[first.id] == NOT_USED else other.answers[0].key
    return out


def asked_once(tables: Sequence[RawTable], questions: Sequence[Question]) -> list[Question]:
    """The questions without those that have the answer of another; that one names the columns that it is for."""
    group = {table.label: number for number, own in enumerate(_equal(tables)) for table in own}
    sets: dict[object, list[Question]] = {}
    for question in questions:
        own = (group.get(question.table, question.table), question.column, question.about)
        sets.setdefault(("doubt", question.doubt) if question.doubt else own, []).append(question)
    out = []
    for first, *others in sets.values():
        files = list(dict.fromkeys(q.table for q in others if q.table != first.table))
        columns = list(dict.fromkeys(q.column for q in others if q.column != first.column))
        also = ", ".join([*(f"column {name!r}" for name in columns), *(f"file {name}" for name in files)])
        out.append(replace(first, text=f"{first.text} The answer is also that of {also}.") if also else first)
    return out


def _equal(tables: Sequence[RawTable]) -> list[list[RawTable]]:
    """Tables of several files, and runs of one file, whose columns have equal names and units."""
    sets: dict[object, list[RawTable]] = {}
    for table in tables:
        sheet = table.sheet if len(table.columns) < FEWEST_OF_RUN else ""
        sets.setdefault((sheet, *((c.name, c.unit) for c in table.columns)), []).append(table)
    return [own for own in sets.values() if len(own) > 1]
