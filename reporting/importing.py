"""An import for the terminal and for notebooks: columns, steps, faults."""

from __future__ import annotations

from collections.abc import Sequence
from html import escape
from typing import TYPE_CHECKING

from . import tables
from .numbers import MISSING
from .tables import Column, Table, field, make_table, numeric

if TYPE_CHECKING:
    from ..datasets.importing.draft import DraftColumn, Question
    from ..datasets.importing.result import ChannelSource, FileFault, ImportReport
    from ..datasets.record import Record

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


def terminal(report: ImportReport, records: Sequence[Record]) -> str:
    """Columns, what was done, faults, records."""
    parts = [tables.console(column_table(report.columns)), "", tables.console(channel_table(report.channels)), ""]
    parts += report.steps
    if report.faults:
        parts += ["", "to be looked at:", tables.console(fault_table(report.faults), indent="  ")]
    return "\n".join([*parts, "", *(repr(record).strip("<>") for record in records)])


def draft_text(columns: Sequence[DraftColumn], questions: Sequence[Question], faults: Sequence[FileFault]) -> str:
    """Columns, what is asked with the lines of a map that answer it, and faults."""
    parts = [tables.console(column_table(columns)), ""] if columns else []
    for question in questions:
        parts += [question.text, *(f"    {answer.line}" for answer in question.answers)]
        parts += [f"    or a number: {question.number}"] if question.number else []
    return "\n".join([*parts, *([tables.console(fault_table(faults))] if faults else [])])


def notebook(report: ImportReport, records: Sequence[Record]) -> str:
    """The same as HTML."""
    steps = "".join(f"<li>{escape(step)}</li>" for step in report.steps)
    faults = tables.html(fault_table(report.faults)) if report.faults else ""
    told = "".join(f"<p>{escape(repr(record))}</p>" for record in records)
    made = tables.html(column_table(report.columns)) + tables.html(channel_table(report.channels))
    return f"{made}<ul>{steps}</ul>{faults}{told}"


def draft_notebook(columns: Sequence[DraftColumn], questions: Sequence[Question]) -> str:
    """Columns and open questions as HTML."""
    asked = [f"{question.text} ({', '.join(answer.key for answer in question.answers)})" for question in questions]
    listed = "".join(f"<li>{escape(text)}</li>" for text in asked)
    return f"{tables.html(column_table(columns))}<ul>{listed}</ul>"


def _number(value: float) -> str:
    return MISSING if value != value else f"{value:.{6 if abs(value) < 1e6 else 11}g}"


def _short(text: str) -> str:
    return text if len(text) <= LONGEST else text[: LONGEST - 1] + "…"
