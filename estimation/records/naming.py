"""Names that tell records and models apart."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence

from ...datasets.record import Record


def numbered(names: Sequence[str]) -> list[str]:
    """The names; those that repeat get a number: `run`, `run (2)`."""
    counts: Counter[str] = Counter()
    out: list[str] = []
    for name in names:
        counts[name] += 1
        out.append(name if counts[name] == 1 else f"{name} ({counts[name]})")
    return out


def named(records: Sequence[Record]) -> dict[str, Record]:
    """Records by name; those that repeat get a number."""
    return dict(zip(numbered([record.name for record in records]), records, strict=True))
