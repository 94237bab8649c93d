"""What the checks of the files say in a diagnosis: they are told, and while one stands nothing is said of the hull."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import TYPE_CHECKING

from ..checks.registry import check_of, sensor_errors
from ..checks.result import CheckFinding
from .report.bank import BY_FREE_RUNS, demoted, is_of_record, lines, of_columns, of_left_out_samples, with_causes
from .report.verdict import motion_explained, next_manoeuvre, without_motion
from .result import Diagnosis

if TYPE_CHECKING:
    from ..datasets.record import Record
    from .result import Finding

REFUTED = 0.8
"""Share of the squared yaw motion that free runs hold along the recorded rudder from which it cannot but act."""


def with_checks(diagnosis: Diagnosis, checks: tuple[CheckFinding, ...], records: Sequence[Record]) -> Diagnosis:
    """The diagnosis with what the files of all records showed: named where it is a cause of the bank; and without a
    word of the model while records stand in doubt, or where free runs do not follow the motion: then forces are told
    alone that no model holds, as those of a measured wind."""
    diagnosis, lost = replace(diagnosis, checks=checks), without_motion(diagnosis.traces)
    beyond = tuple(f for f in diagnosis.remaining if not f.extended and "time" not in f.depends_on)
    if lost is not None and not beyond and diagnosis.verdict in ("named", "tied", "described"):
        diagnosis = replace(diagnosis, verdict="unexplained", reason=lost)
    for name in dict.fromkeys(f.cause for f in checks if check_of(f.cause).is_cause and f.blanked):
        diagnosis = named_first(diagnosis, of_left_out_samples(name, checks, records))
    known = {f.cause for f in diagnosis.causes}
    for name in dict.fromkeys(f.cause for f in checks if f.corrected and not f.blanked and f.cause not in known):
        diagnosis = named_first(diagnosis, of_columns(name, checks, records))
    diagnosis, standing = _refuted(diagnosis, [f for f in checks if f.standing])
    if standing:
        first = f"{', '.join(standing[0].records)}: {standing[0].evidence}"
        reason = f"nothing can be said of the model while the records are in doubt: {first}"
        if any(check_of(f.cause).where != "rudder" for f in standing):  # no channel can be compared then
            sensors = {error.id for error in sensor_errors()}
            diagnosis = replace(diagnosis, causes=tuple(f for f in diagnosis.causes if f.cause not in sensors))
        return _withheld(diagnosis, "inconclusive", reason, "the records are in doubt")
    extended = any(force.extended for force in diagnosis.remaining)
    if lost is not None and (extended or not all(map(is_of_record, diagnosis.causes))):
        said = "free runs with all that fits do not follow even half of the yaw motion"
        outcome = _withheld(diagnosis, "unexplained", f"{said}: no number of the hull is named", said)
        if not beyond:
            return outcome
        said += f"; what they lack is described, and no model holds it: {beyond[0].text}"
        return replace(outcome, verdict="described", reason=said, remaining=beyond)
    return diagnosis


def _refuted(diagnosis: Diagnosis, standing: Sequence[CheckFinding]) -> tuple[Diagnosis, list[CheckFinding]]:
    """The diagnosis with doubts about the rudder taken back where free runs with it follow the training records that
    they are of, and the doubts that stand: those of the size of its angles do, as a model's own gain takes up any
    factor."""
    of_rudder = [f for f in standing if check_of(f.cause).where == "rudder" or f.stage == BY_FREE_RUNS]
    of_rudder = [f for f in of_rudder if all(size.unit != "rad" for size in f.sizes)]
    train = [t for t in diagnosis.traces if t.role == "train"]
    shares = [motion_explained([t for t in train if t.record in f.records]) or 0.0 for f in of_rudder]
    refuted = [f for f, share in zip(of_rudder, shares, strict=True) if share >= REFUTED]
    said = tuple(
        f"{f.evidence}; yet free runs with it hold {100.0 * share:.0f} % of the yaw motion"
        for f, share in zip(of_rudder, shares, strict=True)
        if f in refuted
    )
    checks = tuple(replace(f, standing=False) if f in refuted else f for f in diagnosis.checks)
    return replace(diagnosis, checks=checks, doubts=(*diagnosis.doubts, *said)), [
        f for f in standing if f not in refuted
    ]


def named_first(diagnosis: Diagnosis, finding: Finding) -> Diagnosis:
    """The diagnosis with one cause more, first of all."""
    return with_causes(diagnosis, (finding, *(f for f in diagnosis.causes if f.cause != finding.cause)))


def _withheld(diagnosis: Diagnosis, verdict: str, reason: str, why: str) -> Diagnosis:
    """The diagnosis without what it takes the records' word for: no cause of the model, no numbers, no extension."""
    kept = tuple(filter(is_of_record, diagnosis.causes))
    bank = lines(kept, demoted(diagnosis.bank, ("named", "tied", "explained_by"), "not_testable", why))
    return replace(
        diagnosis,
        verdict=verdict,
        reason=reason,
        causes=kept,
        bank=bank,
        extended=diagnosis.model,
        gain={},
        hypothesis=None,
        remaining=(),
        where=(),
        next_manoeuvre=diagnosis.next_manoeuvre or (next_manoeuvre(reason, ()) if verdict == "inconclusive" else None),
        traces=tuple(replace(t, after=t.before) for t in diagnosis.traces),
        calibrated=None,
        calibrated_gain={},
    )
