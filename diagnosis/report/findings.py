"""Findings: what each stage of a diagnosis names, with sizes and evidence, as results tell it."""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from typing import TYPE_CHECKING

import numpy as np

from ...checks.fault import SENSED
from ...checks.registry import check_of
from ...checks.result import NORMAL_90, Size
from ...checks.statistics.tails import log_tail
from ..result import Finding
from ..selection.levels import adjusted
from ..state import covariance

if TYPE_CHECKING:
    from ...checks.fault import ColumnFault
    from ...checks.result import CheckFinding
    from ...datasets.record import Record
    from ..candidate import Candidate
    from ..causes.base import Cause
    from ..state import State

BY_CHANNELS, BY_RESIDUALS = "kinematics", "dynamics"
BY_FREE_RUNS = "free runs"
"""Stages that name something."""
FAINT = 1e-6
"""Probability that stands for a fault of a file, which is counted and not tested."""
SMALL = "below the size that matters"


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
