"""What the residuals say, as results tell it: verdict, findings, the lines of the bank, hypothesis and noise."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, Any

import numpy as np

from ...checks.tails import adjusted, chi2_quantile, shifted_chi2_tail
from ...estimation.filters.innovations.vector import SYMBOLS
from ...models.model import CHANNELS as COLUMNS
from ..causes.base import Cause
from ..causes.registry import causes
from ..report.bank import BY_RESIDUALS, lines, of_channels
from ..result import Entry, Finding
from .state import Unmodelled, covariance, matters
from .unmodelled import confirmed

if TYPE_CHECKING:
    from ...checks.base import Check
    from ...datasets.record import Record
    from ...estimation.filters.innovations.estimator import Estimator
    from ...estimation.filters.innovations.settings import Setting
    from .state import Candidate, State


EXCITED = 8.0
"""Yaw motion over its sensor's noise (rms, smoothed) below which a record tells nothing about manoeuvring."""
RUDDER_MOVED = np.deg2rad(0.3)
FAINTEST = (1e-6, 1e-8)
"""Heading (rad) and yaw rate (rad/s) that no sensor resolves."""
PLAIN = "the residuals are those of the model, its sensors' noise and zero-mean gusts"
SMALL = "below the size that matters"


# ---- verdict
def undecidable(est: Estimator, start: Setting) -> str | None:
    """Why the records cannot decide anything (too little motion, too few samples), None if they can."""
    moved = max(float(np.std(d.rudder)) for d in est.segments)
    strongest = 0.0
    for d in est.segments:
        for c in (0, 1):
            y = d.measured[:, c]
            y = y[np.isfinite(y)]
            if y.size < 20:
                continue
            size = max(1, y.size // 200)
            mean = y[: y.size // size * size].reshape(-1, size).mean(axis=1)
            if np.std(y) > FAINTEST[c]:
                strongest = max(strongest, float(np.std(mean) / (start.noise.sensor_sd[c] / np.sqrt(size))))
    if moved < RUDDER_MOVED or strongest < EXCITED:
        return (
            f"the rudder moves by {np.rad2deg(moved):.2f} deg (sd) and the yaw motion is {strongest:.1f} times its "
            "sensor's noise: the records hold no manoeuvre"
        )
    if est.n_values < 60:
        return f"{est.n_values} measured values are too few"
    return None


def decide(poor: str | None, left: Candidate | None, instead: bool, findings: Sequence[Finding]) -> tuple[str, str]:
    """The verdict by precedence, and the sentence that supports it.

    left : what is not explained; instead: it stands in the place of what was named, not beside it.
    """
    if poor is not None:
        return "inconclusive", poor
    if left is not None:
        effect = left.cause.label if isinstance(left.cause, Unmodelled) else left.cause.id
        if instead:
            return "unexplained", f"one other effect ({effect}) is as likely as all that is named"
        return "unexplained", f"an effect remains unexplained: {effect}"
    ties = [f for f in findings if f.tied_with]
    if ties:
        said = "; ".join(f"{f.cause} cannot be told from {' or '.join(f.tied_with)}" for f in ties)
        return "tied", said
    if findings:
        return "named", f"with what is named, {PLAIN}"
    return "adequate", PLAIN


# ---- findings
def findings_of(state: State, reasons: Mapping[str, str], rng: np.random.Generator) -> list[Finding]:
    """The accepted causes, the strongest first.

    reasons : cause (id) that the extended model does not hold -> why, which its finding tells.
    """
    spread, at, out = covariance(state), len(state.nuisance), []
    for cause, a in zip(state.causes, state.accepted, strict=True):
        k = len(a.variant)
        block = spread[at : at + k, at : at + k]
        at += k
        said = _evidence(cause, a, state.n_effective)
        if cause.id in reasons:
            said += f"; left out of the extended model: {reasons[cause.id]}"
        out.append(
            Finding(
                cause.id,
                tuple(tied.id for tied in a.tied),
                BY_RESIDUALS,
                a.statistic,
                adjusted(a.log_p, state.n_effective),
                cause.sizes(state.est, state.setting, a.variant, block, rng),
                details=dict(cause.details(state.est, a.variant)),
                evidence=said,
                separate_by=cause.separate_by if a.tied else None,
            )
        )
    return sorted(out, key=lambda f: -(f.statistic or 0.0))


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


# ---- bank
def bank_of(
    state: State, cannot: Mapping[Cause, str], sensors: Mapping[str, float], immaterial: Mapping[str, str],
    findings: Sequence[Finding],
) -> tuple[Entry, ...]:  # fmt: skip
    """The bank of an exact base model.

    sensors : statistics of causes that the channels have decided on.  immaterial : causes (ids) that the records show
    and that do not matter, with the reason.
    """

    def otherwise(check: Check) -> Entry:
        if isinstance(check, Cause):
            return _tested(state, check, cannot, sensors)
        if check.id in sensors:
            return of_channels(check.id, sensors, None)
        return Entry(check.id, "not_significant", None, None, None, "no evidence in the records")

    why = {cause: f"detectable, immaterial: {reason}" for cause, reason in immaterial.items()}
    every = lines(findings, map(otherwise, causes().values()))
    return tuple(replace(e, status="explained_by", why=why[e.cause]) if e.cause in why else e for e in every)


def _tested(state: State, cause: Cause, cannot: Mapping[Cause, str], sensors: Mapping[str, float]) -> Entry:
    statistic, p = _first_statistic(state, cause)
    own = power(state, cause)
    if cause.id in sensors:
        return of_channels(cause.id, sensors, own)
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
        return candidate.statistic, adjusted(candidate.log_p, state.n_effective)
    screened = state.screened.get(cause)
    return (None, None) if screened is None else (screened.score.statistic, adjusted(screened.log_p, state.n_effective))


def power(state: State, cause: Cause) -> float | None:
    """Power of a cause's test at the size that its power is stated for, at the family-wise level; None without one."""
    screened = state.screened.get(cause)
    if screened is None or cause.power_size is None:
        return None
    p, k = screened.variant[0], len(screened.variant)
    size = cause.power_size * (state.est.clock if p.unit == "s" else 1.0)
    noncentrality = float(screened.score.information[0, 0]) * size**2
    threshold = chi2_quantile(state.alpha / state.n_effective, k)
    return shifted_chi2_tail(threshold, k, max(noncentrality, 1e-9))


# ---- hypothesis and noise
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
