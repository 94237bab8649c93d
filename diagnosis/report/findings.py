"""Findings: what each stage of a diagnosis names, with sizes and evidence, as results tell it."""

from __future__ import annotations

from collections.abc import Collection, Sequence
from typing import TYPE_CHECKING

import numpy as np

from ...checks.fault import SENSED
from ...checks.registry import check_of
from ...checks.result import NORMAL_90, Size
from ...checks.tails import adjusted, log_tail
from ..result import Finding

if TYPE_CHECKING:
    from ...checks.fault import ColumnFault
    from ...checks.result import CheckFinding
    from ...datasets.record import Record

BY_CHANNELS, BY_RESIDUALS = "kinematics", "dynamics"
BY_FREE_RUNS = "free runs"
"""Stages that name something."""
FAINT = 1e-6
"""Probability that stands for a fault of a file, which is counted and not tested."""


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
