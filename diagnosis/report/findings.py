"""Findings: what each stage of a diagnosis names, with sizes and evidence, as results tell it."""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, Any

import numpy as np

from ...checks.fault import SENSED
from ...checks.registry import check_of
from ...checks.result import NORMAL_90, Size
from ...checks.statistics.tails import log_tail, student_tail
from ...models.plain import plain
from ..causes.base_coefficients import BaseCoefficients
from ..causes.rudder_effectiveness import RudderEffectiveness
from ..result import Finding
from ..selection.levels import adjusted
from ..state import covariance

if TYPE_CHECKING:
    from ...checks.columns._base import ColumnFault
    from ...checks.result import CheckFinding
    from ...datasets.record import Record
    from ...estimation.filters.innovations.estimator import Estimator
    from ...estimation.filters.innovations.settings import Setting
    from ..calibration.result import Calibration, Moved, StatedRegime, StepTold
    from ..candidate import Candidate
    from ..causes.base import Cause
    from ..discrepancy.shares import Share
    from ..discrepancy.told import Sized
    from ..state import State

BY_CHANNELS, BY_RESIDUALS = "kinematics", "dynamics"
BESIDE_NUMBERS, BY_FREE_RUNS = "beside the base model's own numbers", "free runs"
"""Stages that name something."""
FAINT = 1e-6
"""Probability that stands for a fault of a file, which is counted and not tested."""
DIFFERENT = 0.01
"""Probability of equal sizes in all records below which a size is said to differ."""
TAKEN_BACK = 0.1
"""Share of a sensor's size up to which what two stages say of it together is nothing."""
UNITS = {"rudder_offset": "rad"}
SMALL = "below the size that matters"
HULL = "a description of the hull, which wrong numbers of the base model cannot be told from"


# ---- by files and channels
def of_fault(fault: ColumnFault) -> Finding:
    """What is told of a gross fault that was corrected."""
    p = adjusted(log_tail(fault.statistic, 1), 1.0)
    details = dict(fault.details)
    return Finding(fault.check.id, (), BY_CHANNELS, fault.statistic, p, (), details=details, evidence=fault.evidence)


def of_left_out_samples(name: str, checks: Sequence[CheckFinding], records: Sequence[Record]) -> Finding:
    """Samples that were left out, as one share over all channels."""
    own = [f for f in checks if f.cause == name]
    lost = sum(f.blanked for f in own)
    kept = sum(int(np.isfinite(r.column(c)).sum()) for r in records for c in SENSED if r.has(c))
    share = lost / max(kept + lost, 1)
    half = NORMAL_90 * float(np.sqrt(share * (1.0 - share) / max(kept + lost, 1)))
    size = Size("share", share, max(share - half, 0.0), share + half, "1")
    said, beyond, details = "; ".join(f.evidence for f in own), check_of(name).beyond, {}
    limits = [s for f in own for s in f.sizes if beyond is not None and s.parameter == beyond[1]]
    if beyond is not None and limits:
        low, middle, high = np.quantile([s.value for s in limits], (0.0, 0.5, 1.0)).tolist()
        details = {"regime": {"variable": beyond[0], "side": "above", "threshold": middle, "low": low, "high": high}}
        limits = [Size(beyond[1], middle, low, high, limits[0].unit)]
    return Finding(name, (), BY_CHANNELS, float(lost), FAINT, (*limits, size), details=details, evidence=said)


def of_sensor(f: CheckFinding, known: Collection[str]) -> Finding:
    statistic = float((f.z or 0.0) ** 2)
    details = {} if f.p_equal is None else {"p of equal sizes in all records": f.p_equal}
    return Finding(
        f.cause,
        tuple(name for name in f.tied_with if name in known),
        BY_CHANNELS,
        statistic,
        adjusted(log_tail(statistic, 1), len(known)),
        f.sizes,
        details=details,
        evidence=f.evidence,
        separate_by=f.separate_by if f.tied_with else None,
    )


def once(of_channels: Sequence[Finding], of_motion: Sequence[Finding]) -> list[Finding]:
    """Findings of both stages, a cause that both name once, of both sizes together; not at all where the second size
    takes the first one back, which was that of a cause it was tied with."""
    sized = {f.cause for f in of_channels if f.sizes}
    twice = {f.cause: f for f in of_motion if f.sizes and f.cause in sized}
    out = []
    for f in of_channels:
        if f.cause not in twice or not f.sizes:
            out.append(f)
            continue
        one, other = f.sizes[0], twice[f.cause].sizes[0]
        middle = one.value + other.value
        half = 0.5 * float(np.hypot(one.high - one.low, other.high - other.low))
        if abs(middle) > max(half, TAKEN_BACK * abs(one.value)):
            both = replace(one, value=middle, low=middle - half, high=middle + half)
            out.append(replace(f, sizes=(both,), evidence=f"{f.evidence}; {twice[f.cause].evidence}"))
    return [*out, *(f for f in of_motion if f.cause not in twice or not f.sizes)]


# ---- by residuals
def of_residuals(state: State, barred: Mapping[str, str], rng: np.random.Generator) -> list[Finding]:
    """The accepted causes, the strongest first.

    barred : causes (ids) that the extended model does not hold, with the reason, which their findings tell.
    """
    spread, at, found = covariance(state), len(state.nuisance), []
    for cause, a in zip(state.causes, state.accepted, strict=True):
        k = len(a.variant)
        block = spread[at : at + k, at : at + k]
        at += k
        said = _evidence(cause, a, state.n_effective)
        if cause.id in barred:
            said += f"; left out of the extended model: {barred[cause.id]}"
        found.append(
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
    return sorted(found, key=lambda f: -f.statistic)


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


# ---- beside the base model's own numbers
def of_cause_beside(one: Sized, s: Setting, est: Estimator, drop: Share, rng: np.random.Generator) -> Finding:
    """A cause that matters; s : the setting with the causes alone."""
    a = one.accepted
    sizes: tuple[Size, ...] = a.cause.sizes(est, s, one.variant, one.covariance, rng) if one.variant else ()
    if not one.variant:
        sizes = a.cause.sizes(est, a.fitted.setting, (), np.zeros((0, 0)), rng)
    details = dict(a.cause.details(est, one.variant)) if one.variant else {}
    details["share of the free-run error"] = round(drop.value, 3)
    if one.p_equal is not None and one.p_equal < DIFFERENT:
        details["differs between records, p of equal sizes"] = one.p_equal
        details["standard deviation between records"] = one.between
    said = (
        f"twice the gain of marginal likelihood beside the base model's own numbers is {a.statistic:.1f}; takes off "
        f"{drop.text} of the base model's squared free-run error in records that were left out"
    )
    p = adjusted(a.log_p)
    ties, separate = tuple(c.id for c in a.tied), a.cause.separate_by if a.tied else None
    return Finding(
        a.cause.id, ties, BESIDE_NUMBERS, a.statistic, p, sizes, details=details, evidence=said, separate_by=separate
    )


def of_the_hull(f: Finding) -> Finding:
    """The finding of a cause that describes the hull, as the base model's own numbers do."""
    return replace(f, tied_with=(*f.tied_with, BaseCoefficients.id), evidence=f"{f.evidence}; {HULL}")


def of_numbers(z: np.ndarray, off: float, part: Share, gain: bool) -> Finding:
    """That the base model's own numbers are wrong.

    Which ones is not told: what a ridge moves is correlated with what is wrong, and no more (see
    `discrepancy.subsets`).

    z : numbers over their standard deviations.  off : rms of the numbers, in prior standard deviations.  part : what
    they take off free runs.  gain : whether the turning gain of a response model is one of them.
    """
    said = (
        f"the model's own numbers, off by {off:.2g} prior standard deviations or so, "
        f"take off {part.text} of the squared error of free runs of records that were left out"
    )
    ties, separate = ((RudderEffectiveness.id,), RudderEffectiveness.separate_by) if gain else ((), None)
    strength = float(np.sum(z**2))
    return Finding(BaseCoefficients.id, ties, BESIDE_NUMBERS, strength, 0.0, (), evidence=said, separate_by=separate)


# ---- by free runs of left-out records
def of_groups(base: Calibration, cause: str, groups: Collection[str]) -> Finding:
    """A cause that free runs name, or the base model's own numbers, by groups of numbers."""
    steps = [step for step in base.steps if step.group in groups]
    strongest = max(step.gain / max(step.standard_error, 1e-12) for step in steps)
    p = min(1.0, len(base.steps) * student_tail(strongest, max(len(base.runs) - 1, 1)))
    said = "; ".join(map(_of_step, steps))
    details: dict[str, Any] = {"groups": list(dict.fromkeys(step.title for step in steps))}
    ties = sorted({name.replace("_", " ") for step in steps for name in step.tied_with})
    if ties:
        details["would do as well"] = ties
    sizes = tuple(_size_of(m) for m in base.moved if m.group in groups)
    if base.regime is not None and base.regime.group in groups:
        details["regime"] = plain(base.regime)
        p, said = min(p, float(np.exp(-base.regime.lead))), f"{said}; {_of_regime(base.regime)}"
    return Finding(cause, (), BY_FREE_RUNS, strongest, p, sizes, details=details, evidence=said)


def _of_step(step: StepTold) -> str:
    return (
        f"{step.title}: score of left-out records falls by {step.gain:.2f} (standard error {step.standard_error:.2f})"
    )


def _of_regime(regime: StatedRegime) -> str:
    return (
        f"in its regime the log likelihood, less the price of its parameters, is {regime.lead:.1f} nats above that of "
        f"any numbers that are wrong everywhere; takes off {100.0 * regime.share_of_error:.0f} % of the squared "
        "free-run error of left-out records"
    )


def _size_of(m: Moved) -> Size:
    if m.where and m.percent is not None:
        value, low, high = (x / m.before - 1.0 for x in (m.after, m.low, m.high))
        return Size(m.parameter, value, min(low, high), max(low, high), "1")
    return Size(m.parameter, m.after, m.low, m.high, UNITS.get(m.name, "1"))
