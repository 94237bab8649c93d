"""What an import says: columns, what was made of them, faults."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

from ..datasets.importing.result import Import
from .numbers import MISSING
from .page import FAIR, GOOD, Block, Page, Verdict, items, result_page
from .tables import Column, Table, field, make_table, numeric

if TYPE_CHECKING:
    from ..datasets.importing.draft import DraftColumn, Question
    from ..datasets.importing.importer import Drafted
    from ..datasets.importing.result import ChannelSource, FileFault

TITLES = ("Columns", "What was made of them", "To be looked at", "")
LONGEST = 28
"""Characters of first values that are shown."""


def column_table(columns: Sequence[DraftColumn]) -> Table:
    """A row a column of the log: what it was taken for, and how surely."""
    several = len({row.table for row in columns}) > 1
    shown = [
        *([field("table")] if several else []),
        field("column"),
        field("quantity", "is"),
        field("unit"),
        field("sign"),
        numeric("smallest", "smallest", _number),
        numeric("largest", "largest", _number),
        Column("first values", lambda row: _short(", ".join(row.samples))),
        Column("sure", lambda row: row.sure if row.used else MISSING),
        field("why"),
    ]
    return make_table(shown, columns)


def fault_table(faults: Sequence[FileFault]) -> Table:
    """A row a fault."""
    shown = [
        field("table", "file"),
        Column("row", lambda fault: "" if fault.row is None else str(fault.row)),
        Column("column", lambda fault: fault.column or ""),
        field("message", "fault"),
        field("hint", "what to do"),
    ]
    return make_table(shown, sorted(faults, key=lambda fault: not fault.fatal))


def channel_table(channels: Sequence[ChannelSource]) -> Table:
    """A row a channel: the columns that it is made of, and how surely."""
    several = len({row.record for row in channels}) > 1
    shown = [
        *([field("record")] if several else []),
        field("channel"),
        Column("of columns", lambda row: ", ".join(row.columns)),
        field("sure"),
    ]
    return make_table(shown, channels)


def page(found: Import | Drafted) -> Page:
    """The page of an import, or of its draft with the lines of a map that answer each question."""
    if isinstance(found, Import):
        columns, faults = found.report.columns, found.report.faults
        verdict = Verdict(FAIR if faults else GOOD, f"{'; '.join(repr(one).strip('<>') for one in found.records)}.")
        made: list[Block] = [channel_table(found.report.channels), items(found.report.steps)]
    else:
        columns, faults, asked = found.columns, found.faults, len(found.questions)
        verdict = Verdict(
            FAIR if asked or faults else GOOD, f"{asked} question{'s are' if asked != 1 else ' is'} open."
        )
        made = [items([_asked(question) for question in found.questions])]
    seen, looked_at = [column_table(columns)], [fault_table(faults)]
    return result_page("Import", "", verdict, seen=seen, changed=made, remains=looked_at, titles=TITLES)


def _asked(question: Question) -> tuple[str, ...]:
    number = [f"or a number: {question.number}"] if question.number else []
    return (question.text, *(answer.line for answer in question.answers), *number)


def _number(value: float) -> str:
    return MISSING if value != value else f"{value:.{6 if abs(value) < 1e6 else 11}g}"


def _short(text: str) -> str:
    return text if len(text) <= LONGEST else text[: LONGEST - 1] + "…"
