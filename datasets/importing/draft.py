"""The draft of an import: every column of a log, what it was taken for, why, and the questions that are open."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import asdict, dataclass
from typing import Any, Literal, TypeAlias

Sure: TypeAlias = Literal["stated", "other channel", "physics", "guess"]
"""How surely a column is known: the file, its format, the map or an answer states it; another channel agrees; nothing
else is physically possible; or it is a guess, and then there is a question."""
About: TypeAlias = Literal["quantity", "unit", "sign", "time", "numbers", "rudder side", "file", "columns"]
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
