"""Findings of files and channels, with sizes and evidence, and the bank: one line for every cause of the taxonomy."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Mapping, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from ...checks.base import SENSED
from ...checks.columns import RudderSign
from ...checks.registry import check_of
from ...checks.result import NORMAL_90, Size
from ...checks.tails import adjusted, log_tail
from ..causes.registry import cause
from ..result import Entry, Finding

if TYPE_CHECKING:
    from ...checks.base import Fault
    from ...checks.result import CheckFinding
    from ...datasets.record import Record
    from ...models.model import Model
    from ..result import Diagnosis

BY_CHANNELS, BY_RESIDUALS = "kinematics", "dynamics"
BY_FREE_RUNS = "free runs"
"""Stages that name something."""
DECIDED = "the sensors' channels were compared with each other and show no more of it"


# ---- findings
def is_of_record(finding: Finding) -> bool:
    """Whether a finding is of the records: their channels show it, or no number of a model stands for its cause."""
    return finding.stage == BY_CHANNELS or cause(finding.cause).of_record


def of_fault(cause: str, fault: Fault, records: Sequence[str] = ()) -> Finding:
    """What is told of a gross fault of a cause (id) that was corrected; records : that alone have it."""
    p = adjusted(log_tail(fault.statistic, 1), 1.0)
    details = {"channels": list(fault.channels)} | ({"records": list(records)} if records else {})
    return Finding(cause, (), BY_CHANNELS, fault.statistic, p, (), details=details, evidence=fault.evidence)


def of_model_side(model: Model) -> Finding:
    """That a base model states the other side than that to which a positive rudder angle turns it, as this one does."""
    said = (
        f"the base model's numbers turn it to {model.positive_rudder} with a positive rudder angle, and it states the "
        f"other side: it was run with positive_rudder: {model.positive_rudder}"
    )
    return Finding(RudderSign.id, (), BY_FREE_RUNS, None, None, (), details={"of": "base model"}, evidence=said)


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
    return Finding(name, (), BY_CHANNELS, None, None, (*limits, size), details=details, evidence=said)


def of_columns(name: str, checks: Sequence[CheckFinding], records: Sequence[Record]) -> Finding:
    """Columns that were corrected as a whole, their sign or unit, in all of the records or some."""
    own = [f for f in checks if f.cause == name]
    columns = list(dict.fromkeys(channel for f in own for channel in f.channels))
    names, said = list(dict.fromkeys(r for f in own for r in f.records)), "; ".join(f.evidence for f in own)
    details = {"columns": columns} | ({"records": names} if len(names) < len(records) else {})
    sizes = tuple(size for f in own for size in f.sizes) if check_of(name).unit == "s" else ()
    return Finding(name, (), BY_CHANNELS, None, None, sizes, details=details, evidence=said)


def of_sensor(f: CheckFinding, known: Collection[str]) -> Finding:
    statistic = float((f.z or 0.0) ** 2)
    details = {} if f.p_equal is None else {"p-value of equal sizes in all records": f.p_equal}
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


# ---- bank
def lines(findings: Sequence[Finding], entries: Iterable[Entry]) -> tuple[Entry, ...]:
    """The line of every cause: of what is named or tied as its finding says, of the others as it is."""
    return tuple(_line(entry, findings) for entry in entries)


def _line(entry: Entry, findings: Sequence[Finding]) -> Entry:
    own = next((f for f in findings if f.cause == entry.cause), None)
    if own is not None:
        status = "tied" if own.tied_with else "named"
        return replace(entry, status=status, statistic=own.statistic, p_adjusted=own.p_adjusted, why=own.evidence)
    tied = next((f for f in reversed(findings) if entry.cause in f.tied_with), None)
    if tied is not None:
        return replace(entry, status="tied", why=f"cannot be told from {tied.cause} on these records")
    return entry


def demoted(bank: Sequence[Entry], of: Collection[str], status: str, why: str) -> list[Entry]:
    """The bank in which what had one of the statuses `of` has another one, for a reason."""
    return [replace(entry, status=status, why=why) if entry.status in of else entry for entry in bank]


def with_causes(diagnosis: Diagnosis, findings: Sequence[Finding]) -> Diagnosis:
    """The diagnosis with other findings; named by the first of them where it was adequate."""
    if diagnosis.verdict == "adequate" and findings:
        reason = f"{findings[0].cause}: {findings[0].evidence}"
        diagnosis = replace(diagnosis, verdict="named", reason=reason)
    return replace(diagnosis, causes=tuple(findings), bank=lines(findings, diagnosis.bank))


def without_causes(diagnosis: Diagnosis, ids: Collection[str], why: str) -> Diagnosis:
    """The diagnosis without some causes, for a reason that their lines of the bank say."""
    rest = tuple(f for f in diagnosis.causes if f.cause not in ids)
    of = ("named", "tied", "explained_by")
    bank = (e if e.cause not in ids else demoted([e], of, "not_significant", why)[0] for e in diagnosis.bank)
    return replace(diagnosis, causes=rest, bank=tuple(bank))


def of_channels(cause: str, sensors: Mapping[str, float], own: float | None) -> Entry:
    """The line of a cause (id) that the sensors' channels have decided on.

    sensors : its statistic (z squared) and those of the others.  own : power of its own test, None without one.
    """
    p = adjusted(log_tail(sensors[cause], 1), len(sensors))
    return Entry(cause, "not_significant", sensors[cause], p, own, DECIDED)
