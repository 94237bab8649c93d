"""The bank: one line for every cause of the taxonomy."""

from __future__ import annotations

from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING

from ...checks.tails import adjusted, log_tail
from ..causes.registry import causes
from ..result import Entry

if TYPE_CHECKING:
    from ...checks.base import Check
    from ..result import Finding


DECIDED = "the sensors' channels were compared with each other and show no more of it"


def lines(findings: Sequence[Finding], otherwise: Callable[[Check], Entry]) -> tuple[Entry, ...]:
    """One line for every cause: of what is named or tied as its finding says, of the others as `otherwise` does."""
    return tuple(_line(otherwise(check), findings) for check in causes().values())


def _line(entry: Entry, findings: Sequence[Finding]) -> Entry:
    own = next((f for f in findings if f.cause == entry.cause), None)
    if own is not None:
        status = "tied" if own.tied_with else "named"
        return replace(entry, status=status, statistic=own.statistic, p_adjusted=own.p_adjusted, why=own.evidence)
    tied = next((f for f in reversed(findings) if entry.cause in f.tied_with), None)
    if tied is not None:
        return replace(entry, status="tied", why=f"cannot be told from {tied.cause} on these records")
    return entry


def updated(bank: Sequence[Entry], findings: Sequence[Finding]) -> tuple[Entry, ...]:
    """The bank after later findings."""
    known = {entry.cause: entry for entry in bank}
    return lines(findings, lambda check: known[check.id])


def demoted(bank: Sequence[Entry], of: Collection[str], status: str, why: str) -> list[Entry]:
    """The bank in which what had one of the statuses `of` has another one, for a reason."""
    return [replace(entry, status=status, why=why) if entry.status in of else entry for entry in bank]


def of_channels(check: Check, sensors: Mapping[Check, float], own: float | None) -> Entry:
    """The line of a cause that the sensors' channels have decided on.

    sensors : its statistic (z squared) and those of the others.  own : power of its own test, None without one.
    """
    p = adjusted(log_tail(sensors[check], 1), len(sensors))
    return Entry(check.id, "not_significant", sensors[check], p, own, DECIDED)
