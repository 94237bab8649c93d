"""Text of Applanix's POS Export Utility: what its axes state of the roll."""

from __future__ import annotations

from dataclasses import replace

from ..raw import RawTable

TITLE = "POS Export Utility"


def with_pospac(table: RawTable) -> RawTable:
    """A table of that program: its axes are forward, right, down."""
    if not any(TITLE in note for note in table.notes):
        return table
    columns = (
        replace(c, said=(*c.said, "positive to starboard")) if c.name.strip().lower() == "roll" else c
        for c in table.columns
    )
    return replace(table, columns=tuple(columns), done=(*table.done, f"{TITLE}: axes forward, right, down"))
