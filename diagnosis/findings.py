"""What was found, as results tell it: findings with sizes, one line for every cause, the hypothesis, the noise, and the
diagnosis made of them."""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, Any

import numpy as np

from ..checks.base import Check
from ..checks.statistics.tails import log_tail
from ..estimation.filters.innovations.vector import SYMBOLS
from ..models.model import CHANNELS as COLUMNS
from .candidate import Candidate, Unmodelled
from .causes.base import Cause
from .causes.registry import causes
from .residuals.unmodelled import confirmed
from .result import Diagnosis, Entry, Finding, Gain
from .starting import DECIDED
from .state import State, covariance, matters
from .verdict import next_manoeuvre, power, where

if TYPE_CHECKING:
    from ..checks.columns._base import ColumnFault
    from ..datasets.record import Record
    from ..estimation.filters.innovations.estimator import Estimator
    from ..estimation.filters.innovations.settings import Setting
    from ..models.model import Model
    from .kinematics.stage import Shown
    from .options import Options
    from .trace import Trace

SMALL = "below the size that matters"


def all_findings(
    state: State, faults: Sequence[ColumnFault], shown: Shown, barred: Mapping[str, str],
    immaterial: Collection[str], rng: np.random.Generator,
) -> list[Finding]:  # fmt: skip
    """Findings of all stages.

    barred : causes (ids) that the extended model does not hold, with the reason, which their findings tell.
    immaterial : causes (ids) that are not told.
    """
    own = [_left_out(f, barred) for f in _of_selection(state, rng) if f.cause not in immaterial]
    return [*(of_fault(f) for f in faults), *shown.findings, *own]


def of_fault(fault: ColumnFault) -> Finding:
    """What is told of a gross fault that was corrected."""
    p = float(np.exp(max(log_tail(fault.statistic, 1), -700.0)))
    details = dict(fault.details)
    return Finding(fault.check.id, (), "kinematics", fault.statistic, p, (), details=details, evidence=fault.evidence)


def _left_out(f: Finding, barred: Mapping[str, str]) -> Finding:
    if f.cause not in barred:
        return f
    return replace(f, evidence=f"{f.evidence}; left out of the extended model: {barred[f.cause]}")


def _of_selection(state: State, rng: np.random.Generator) -> list[Finding]:
    spread, at, found = covariance(state), len(state.nuisance), []
    for cause, a in zip(state.causes, state.accepted, strict=True):
        k = len(a.variant)
        block = spread[at : at + k, at : at + k]
        at += k
        found.append(
            Finding(
                cause.id,
                tuple(tied.id for tied in a.tied),
                "dynamics",
                a.statistic,
                adjusted_p(state, a.log_p),
                cause.sizes(state.est, state.setting, a.variant, block, rng),
                details=dict(cause.details(state.est, a.variant)),
                evidence=_evidence(cause, a, state.n_effective),
                separate_by=cause.separate_by if a.tied else None,
            )
        )
    return sorted(found, key=lambda f: -f.statistic)


def adjusted_p(state: State, log_p: float) -> float:
    """A p-value adjusted for the independent tests of the bank."""
    return float(min(1.0, np.exp(log_p + np.log(state.n_effective))))


def _evidence(cause: Cause, a: Candidate, tests: float) -> str:
    k = max(len(a.variant), 1)
    plural = "s" if k > 1 else ""
    said = (
        f"likelihood-ratio statistic {a.statistic:.1f} on {k} parameter{plural}, less the cost of gusts, noise "
        f"refitted (about {tests:.0f} independent tests)"
    )
    if cause.search.counts_values:
        said += f"; scanned values count as {a.tests:.1f} independent tests (bootstrap, the recorded rudder used again)"
    return said


# ---- the bank
def bank_entries(
    state: State,
    cannot: Mapping[Cause, str],
    findings: Sequence[Finding],
    shown: Shown,
    immaterial: Mapping[str, str],
) -> tuple[Entry, ...]:
    """One line for every cause of the taxonomy.

    immaterial : causes (ids) that the records show and that do not matter, with the reason.
    """
    named = {f.cause: f for f in findings}
    tied = {name: f for f in findings for name in f.tied_with}
    every = [
        _entry(state, cause, named, tied, cannot, shown.statistics)
        if isinstance(cause, Cause)
        else _of_check(cause, named)
        for cause in causes().values()
    ]
    why = {cause: f"detectable, immaterial: {reason}" for cause, reason in immaterial.items()}
    return tuple(replace(e, status="explained_by", why=why[e.cause]) if e.cause in why else e for e in every)


def _of_check(check: Check, named: Mapping[str, Finding]) -> Entry:
    """The line of what the records were checked for before all else."""
    f = named.get(check.id)
    if f is None:
        return Entry(check.id, "not_significant", None, None, None, "no evidence in the records")
    return Entry(check.id, "tied" if f.tied_with else "named", f.statistic, f.p_adjusted, None, f.evidence)


def _entry(
    state: State,
    cause: Cause,
    named: Mapping[str, Finding],
    tied: Mapping[str, Finding],
    cannot: Mapping[Cause, str],
    sensors: Mapping[Cause, float],
) -> Entry:
    statistic, p = _first_statistic(state, cause)
    own = power(state, cause)
    if cause.id in named:
        f = named[cause.id]
        return Entry(cause.id, "tied" if f.tied_with else "named", f.statistic, f.p_adjusted, own, f.evidence)
    if cause.id in tied:
        why = f"cannot be told from {tied[cause.id].cause} on these records"
        return Entry(cause.id, "tied", statistic, p, own, why)
    if cause in sensors:
        p = float(min(1.0, len(sensors) * np.exp(log_tail(sensors[cause], 1))))
        return Entry(cause.id, "not_significant", sensors[cause], p, own, DECIDED)
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
        return candidate.statistic, adjusted_p(state, candidate.log_p)
    screened = state.screened.get(cause)
    return (None, None) if screened is None else (screened.score.statistic, adjusted_p(state, screened.log_p))


# ---- what is not named
def hypothesis_of(state: State, left: Candidate | None, records: Sequence[Record]) -> dict[str, Any] | None:
    """The sparse term that fits an unexplained effect best, and whether held-out records confirm it."""
    if left is None:
        return None
    est = state.est
    axes = ("X", "Y", "N") if est.n_forces == 3 else ("N", "N rate")
    terms = []
    for p in left.variant:
        if p.series is not None:
            axis = p.series[0]
            where = axes[axis] if axis < est.n_forces else f"channel {COLUMNS[SYMBOLS[axis - est.n_forces]]}"
            name = p.name.rpartition(":")[0]
            terms.append({"term": name, "acts_on": where, "size": est.value(left.setting, p)})
    return {
        "hypothesis": left.cause.label if isinstance(left.cause, Unmodelled) else left.cause.id,
        "terms": terms,
        "log_p": left.log_p,
        "confirmed_on_held_out": confirmed(state, left, records) if left.variant and records else None,
    }


def noise_of(est: Estimator, s: Setting) -> dict[str, Any]:
    """Estimated noise: sensors by column, forces in N and N m, correlation time, rudder sensor."""
    names = [COLUMNS[symbol] for symbol in SYMBOLS]
    return {
        "sensor_sd": {names[c]: float(s.noise.sensor_sd[c]) for c in np.flatnonzero(est.channels)},
        "force_sd": (s.noise.force_sd * est.unit).tolist(),
        "correlation_time_s": float(s.noise.correlation_time_s),
        "rudder_sd": est.rudder_sd,
    }


# ---- all of it
def diagnosis_of(
    models: tuple[Model, Model],
    options: Options,
    decided: tuple[str, str],
    findings: Sequence[Finding],
    bank: Sequence[Entry],
    predicted: tuple[Mapping[str, Gain], Sequence[Trace]],
    *,
    noise: Mapping[str, Any],
    poor: str | None = None,
    hypothesis: dict[str, Any] | None = None,
    doubts: tuple[str, ...] = (),
) -> Diagnosis:
    """The diagnosis without the names of its records and without its cost, which `diagnose` knows.

    models : base and extended.  decided : verdict and reason.  predicted : gain by channel, traces.  poor : why the
    records cannot decide anything; then no cause is told.
    """
    gain, traces = predicted
    return Diagnosis(
        *models,
        base_parameters=str(options.base_parameters),
        records=(),
        alpha=options.alpha,
        seed=options.seed,
        threads=options.threads,
        verdict=decided[0],
        reason=decided[1],
        causes=tuple(findings) if poor is None else (),
        bank=tuple(bank),
        gain=dict(gain),
        hypothesis=hypothesis,
        noise=dict(noise),
        traces=tuple(traces),
        where=tuple(where(traces)),
        next_manoeuvre=next_manoeuvre(poor, findings),
        wall_s=0.0,
        cpu_s=0.0,
        doubts=doubts,
    )
