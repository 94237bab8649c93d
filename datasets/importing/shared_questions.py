"""One question for several columns: of files with equal headers, and of names with the same doubtful word."""

from __future__ import annotations

from collections.abc import Mapping as Dict
from collections.abc import Sequence
from dataclasses import replace

from .draft import NOT_USED, Question
from .finding import ColumnFinding
from .raw import RawTable


def for_equal_headers(tables: Sequence[RawTable], answers: Dict[str, str]) -> dict[str, str]:
    """The answers, each also for the same column of tables with equal headers."""
    out = dict(answers)
    for group in _equal(tables):
        for table in group:
            for key in [key for key in answers if key.startswith(f"{table.label}/")]:
                rest = key.removeprefix(table.label)
                out |= {f"{other.label}{rest}": answers[key] for other in group if other.label + rest not in answers}
    return out


def for_equal_doubts(findings: Sequence[ColumnFinding], answers: Dict[str, str]) -> dict[str, str]:
    """The answers, each also for the columns whose names raise the same doubt."""
    out = dict(answers)
    asked = [question for found in findings for question in found.questions if question.doubt]
    for first in (question for question in asked if question.id in answers):
        for other in (q for q in asked if q.doubt == first.doubt and q.id not in answers):
            out[other.id] = NOT_USED if answers[first.id] == NOT_USED else other.answers[0].key
    return out


def once(tables: Sequence[RawTable], questions: Sequence[Question]) -> list[Question]:
    """The questions without those that have the answer of another; that one names the columns that it is for."""
    group = {table.label: number for number, own in enumerate(_equal(tables)) for table in own}
    sets: dict[object, list[Question]] = {}
    for question in questions:
        own = (group.get(question.table, question.table), question.column, question.about)
        sets.setdefault(("doubt", question.doubt) if question.doubt else own, []).append(question)
    return [_for_all(own) for own in sets.values()]


def _for_all(questions: Sequence[Question]) -> Question:
    first, *others = questions
    if not others:
        return first
    tables = list(dict.fromkeys(q.table for q in others if q.table != first.table))
    columns = list(dict.fromkeys(q.column for q in others if q.column != first.column))
    also = [*(f"column {name!r}" for name in columns), *(f"file {name}" for name in tables)]
    return replace(first, text=f"{first.text} The answer is also that of {', '.join(also)}." if also else first.text)


def _equal(tables: Sequence[RawTable]) -> list[list[RawTable]]:
    """Tables of several files whose columns have equal names and units."""
    sets: dict[object, list[RawTable]] = {}
    for table in tables:
        sets.setdefault((table.sheet, *((c.name, c.unit) for c in table.columns)), []).append(table)
    return [own for own in sets.values() if len(own) > 1]
