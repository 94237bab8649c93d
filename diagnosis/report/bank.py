"""The bank: one line for every cause of the taxonomy."""

from __future__ import annotations

from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING

from ...checks.statistics.tails import log_tail
from ..causes.base import Cause
from ..causes.registry import causes
from ..result import Entry
from ..selection.levels import adjusted
from ..starting import DECIDED
from ..state import matters
from .findings import SMALL
from .verdict import power

if TYPE_CHECKING:
    from ...checks.base import Check
    from ..candidate import Candidate
    from ..result import Finding
    from ..state import State


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


# ---- by residuals
def of_residuals(
    state: State, cannot: Mapping[Cause, str], sensors: Mapping[Check, float], immaterial: Mapping[str, str],
    findings: Sequence[Finding],
) -> tuple[Entry, ...]:  # fmt: skip
    """The bank of an exact base model.

    sensors : statistics of causes that the channels have decided on.  immaterial : causes (ids) that the records show
    and that do not matter, with the reason.
    """

    def otherwise(check: Check) -> Entry:
        if isinstance(check, Cause):
            return _tested(state, check, cannot, sensors)
        if check in sensors:
            return of_channels(check, sensors, None)
        return Entry(check.id, "not_significant", None, None, None, "no evidence in the records")

    why = {cause: f"detectable, immaterial: {reason}" for cause, reason in immaterial.items()}
    every = lines(findings, otherwise)
    return tuple(replace(e, status="explained_by", why=why[e.cause]) if e.cause in why else e for e in every)


def _tested(state: State, cause: Cause, cannot: Mapping[Cause, str], sensors: Mapping[Check, float]) -> Entry:
    statistic, p = _first_statistic(state, cause)
    own = power(state, cause)
    if cause in sensors:
        return of_channels(cause, sensors, own)
    if cause in cannot:
        return Entry(cause.id, "not_testable", statistic, p, own, cannot[cause])
    if cause in state.failed and _candidate(state, cause) is None:
        return Entry(cause.id, "not_testable", statistic, p, own, state.failed[cause])
    if cause in state.in_span:
        why = "the free coefficients of the base model, or nothing that was measured, can show it"
        return Entry(cause.id, "not_testable", statistic, p, own, why)
    if p is not None and p < state.alpha and state.accepted:
        why = f"significant alone, not beside {state.causes[0].id}"
        return Entry(cause.id, "explained_by", statistic, p, own, why)
    return Entry(cause.id, "not_significant", statistic, p, own, _not_named(state, cause, p))


def of_channels(check: Check, sensors: Mapping[Check, float], own: float | None) -> Entry:
    """The line of a cause that the sensors' channels have decided on.

    sensors : its statistic (z squared) and those of the others.  own : power of its own test, None without one.
    """
    p = adjusted(log_tail(sensors[check], 1), len(sensors))
    return Entry(check.id, "not_significant", sensors[check], p, own, DECIDED)


def _not_named(state: State, cause: Cause, p: float | None) -> str:
    """Why a cause is not named where none is."""
    if p is None or p >= state.alpha:
        return "no evidence in the residuals"
    candidate = _candidate(state, cause)
    if candidate is None:
        return "significant by its score alone, far behind the strongest cause"
    return SMALL if not matters(state, candidate) else "significant alone, but what remains unexplained fits better"


def _candidate(state: State, cause: Cause) -> Candidate | None:
    """A cause refitted in the first step."""
    return next((c for c in state.candidates if c.cause == cause), None)


def _first_statistic(state: State, cause: Cause) -> tuple[float | None, float | None]:
    """Statistic and adjusted p-value of a cause in the first step, refitted or else by its score."""
    candidate = _candidate(state, cause)
    if candidate is not None:
        return candidate.statistic, adjusted(candidate.log_p, state.n_effective)
    screened = state.screened.get(cause)
    return (None, None) if screened is None else (screened.score.statistic, adjusted(screened.log_p, state.n_effective))
