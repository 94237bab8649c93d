"""The tables of a check: findings, their sizes by record, and what could not be checked."""

from __future__ import annotations

from typing import TYPE_CHECKING

from ..diagnosis.words import cause, scale, size
from ..numbers import MISSING, number
from ..tables import Column, Table, make_table

if TYPE_CHECKING:
    from ...checks.result import CheckFinding, CheckResult

SHOWN = 3
"""Records that are named one by one."""


def findings(found: CheckResult, title: str = "Findings") -> Table:
    """One row a finding: cause, size over all records, records, evidence, and what would separate it."""
    columns = [
        Column("finding", name),
        Column("matters", lambda f: "yes" if f.material else "no"),
        Column("size [90 %]", whole_sizes),
        Column("records", lambda f: records(f, len(found.records))),
        Column("evidence", lambda f: f.evidence),
        Column("to be sure", lambda f: f.separate_by or MISSING),
    ]
    return make_table(columns, found.findings, title)


def brief(found: CheckResult) -> Table:
    """The same for the terminal: without the evidence, which stands below."""
    columns = [
        Column("finding", name),
        Column("matters", lambda f: "yes" if f.material else "no"),
        Column("size [90 %]", whole_sizes),
        Column("records", lambda f: records(f, len(found.records))),
    ]
    return make_table(columns, found.findings)


def by_record(found: CheckResult) -> Table:
    """One row a record and size."""
    rows = [(f, s) for f in found.findings for s in f.sizes if s.record is not None and f.stage == "sensors"]
    columns = [
        Column("finding", lambda row: cause(row[0].cause)),
        Column("record", lambda row: row[1].record),
        Column("size [90 %]", lambda row: size(row[1]).removesuffix(f" in {row[1].record}"), lambda row: row[1].value),
    ]
    return make_table(columns, rows, "Sizes by record")


def name(f: CheckFinding) -> str:
    """The cause with those that cannot be told from it, and the columns of a file's fault."""
    alone = " or ".join(map(cause, (f.cause, *f.tied_with)))
    columns = [c for c in f.channels if c != "time_s"] if f.stage == "file" else []
    return f"{alone} ({', '.join(columns)})" if columns else alone


def whole_sizes(f: CheckFinding) -> str:
    """Sizes over all records, or of the one record."""
    whole = [s for s in f.sizes if s.record is None] or (list(f.sizes) if len(f.records) == 1 else [])
    return "; ".join(_short(s).partition(" in ")[0] for s in whole) or MISSING


def _short(s) -> str:
    if s.low != s.high:
        return size(s)
    factor, unit = scale(s)
    return f"{s.parameter} {number(factor * s.value)} {unit}".strip()


def records(f: CheckFinding, total: int) -> str:
    """The records concerned, or how many they are."""
    if len(f.records) == total and total > 1:
        return f"all {total}"
    return ", ".join(f.records) if len(f.records) <= SHOWN else f"{len(f.records)} of {total}"
