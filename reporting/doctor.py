"""The table of what helmbench finds about the machine it runs on."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from .tables import Column, Table, make_table


def health_table(findings: Sequence[Any]) -> Table:
    """A row a finding: status, what it is about, what was found, what to do."""
    columns = [
        Column("status", lambda one: one.status),
        Column("what", lambda one: one.what),
        Column("found", lambda one: one.told),
        Column("to do", lambda one: one.todo),
    ]
    return make_table(columns, findings)
