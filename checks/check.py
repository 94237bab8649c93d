"""`check`: what sensors and files show without a hull model.

First the file of each record (stamps, frozen samples, jumps, units, signs, exchanged columns, copies, outliers), then
sensors, on records with gross faults corrected: heading against yaw rate, then positions against velocities.  Nothing
here knows a vessel, so no fault of a model can appear as one of a sensor.  Every check of the registry is run.
"""

from __future__ import annotations

from collections.abc import Collection, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING

import numpy as np

from ..datasets.columns import HEADING, RUDDERS
from ..models.linear_algebra import blas_limited
from .base import UNUSABLE, FileCheck, cleaned, of_fault
from .columns import RudderSign
from .comparison.chains import Chain, chains, sums, why_not
from .comparison.drift import current_finding, deviation_finding
from .comparison.selection import Compared, compare, of_sizes
from .files.copies import DerivedChannel
from .files.units import WrongUnit, revolutions_units
from .integrity.averages import averages_of
from .registry import check_of, file_checks
from .result import Check, CheckFinding, merged

if TYPE_CHECKING:
    from ..datasets.record import Record
    from .base import Fault


@dataclass
class Examined:
    """Records with gross faults corrected, findings, why something could not be looked for, and by the id of its check
    the clearest fault of a whole column."""

    records: list[Record] = field(default_factory=list)
    findings: list[CheckFinding] = field(default_factory=list)
    reasons: list[str] = field(default_factory=list)
    faults: dict[str, Fault] = field(default_factory=dict)

    @property
    def derived(self) -> dict[str, set[str]]:
        """Name of a record -> columns that are made from each other: they cannot check each other."""
        out: dict[str, set[str]] = {}
        for f in self.findings:
            if f.cause == DerivedChannel.id and f.material:
                out.setdefault(f.records[0], set()).update(f.channels)
        return out


def check(records: Sequence[Record], findings: Iterable[CheckFinding] = ()) -> Check:
    """Check records without a model.

    findings : those that were made on reading the files.
    """
    records = distinct(records)
    with np.errstate(all="ignore"), blas_limited():
        done = examine(records)
        sensors, why = check_sensors(*_trusted(done), done.derived)
    names = tuple(r.name for r in records)
    return Check(names, (*merged([*findings, *done.findings]), *sensors), (*done.reasons, *why))


def _trusted(done: Examined) -> tuple[list[Record], list[str]]:
    """Records whose channels may be compared, and why others may not."""
    doubtful: dict[str, str] = {}
    for f in (f for f in done.findings if f.standing):
        entry = check_of(f.cause)
        if isinstance(entry, FileCheck) and entry.of_logger:
            doubtful |= {r.name: f"{f.records[0]}: {f.evidence}" for r in done.records if r.name not in doubtful}
        if entry.where != "rudder":
            doubtful |= dict.fromkeys(f.records, f.evidence)
    reasons = [f"sensors of {name} are not compared: {evidence}" for name, evidence in doubtful.items()]
    return [r for r in done.records if r.name not in doubtful], reasons


def distinct(records: Sequence[Record]) -> list[Record]:
    """The records under names that differ."""
    out: list[Record] = []
    for record in records:
        taken = {r.name for r in out}
        numbers = (f"{record.name} ({i})" for i in range(2, len(records) + 2))
        name = record.name if record.name not in taken else next(n for n in numbers if n not in taken)
        out.append(replace(record, name=name))
    return out


def examine(records: Sequence[Record]) -> Examined:
    """Files and columns of records: what is wrong with them, and the records corrected as far as possible.

    The records have names that differ.
    """
    right, findings = with_right_revolutions(records)
    done = examine_each(right, file_checks())
    done.findings[:0] = findings
    _check_sides(done)
    return done


def with_right_revolutions(records: Sequence[Record]) -> tuple[list[Record], list[CheckFinding]]:
    """Records with the propeller's revolutions in the unit that most of them have, and what was corrected."""
    faults = revolutions_units(records)
    findings = [of_fault(WrongUnit(), faults[r.name], r) for r in records if r.name in faults]
    return [cleaned(r, [faults[r.name]]) if r.name in faults else r for r in records], findings


def examine_each(records: Iterable[Record], entries: Sequence[FileCheck]) -> Examined:
    """What checks find in each record alone, in order of rank: each on what the ones before have corrected."""
    done = Examined()
    for record in records:
        for entry in entries:
            try:
                faults = entry.find(record)
            except UNUSABLE as error:
                done.reasons.append(f"{entry.id} of {record.name} cannot be looked for: {error}")
                continue
            done.findings += [of_fault(entry, fault, record) for fault in faults]
            for fault in (f for f in faults if f.statistic):
                done.faults[entry.id] = max(fault, done.faults.get(entry.id, fault), key=lambda f: f.statistic)
            record = cleaned(record, faults)
            if entry.ends and any(f.standing for f in faults):
                break
        done.records.append(record)
    return done


def cleaned_of(records: Iterable[Record], ids: Collection[str]) -> list[Record]:
    """Records corrected for what some checks (ids) of each file find, as far as possible."""
    return examine_each(records, [check for check in file_checks() if check.id in ids]).records


def _check_sides(done: Examined) -> None:
    """The sign of the rudders, of the records of one side of a positive rudder together."""
    entry, steered = RudderSign(), [r for r in done.records if _steers(r, done)]
    for side in ("starboard", "port"):
        group = [r for r in steered if r.meta.positive_rudder == side]
        try:
            faults = entry.find(group)
        except UNUSABLE as error:
            done.reasons.append(f"the side of the rudder cannot be checked: {error}")
            continue
        if faults:
            own = [r for r in group if r.name in faults]
            done.findings.append(of_fault(entry, faults[own[0].name], *own))
            done.records = [cleaned(r, [faults[r.name]]) if r.name in faults else r for r in done.records]


def _steers(record: Record, done: Examined) -> bool:
    """Whether a record has a rudder, and no doubt stands about it."""
    return any(map(record.has, RUDDERS)) and not any(f.standing and record.name in f.records for f in done.findings)


def check_sensors(
    records: Sequence[Record], reasons: list[str], derived: dict[str, set[str]]
) -> tuple[list[CheckFinding], list[str]]:
    """Sensor errors of records that are free of gross faults, and why some could not be compared.

    derived : record name -> columns that are made from each other: they are not compared.  Of long records, averages
    are (`averages_of`).
    """
    findings: list[CheckFinding] = []
    current = [averages_of(record) for record in records]
    for done, corrected in compared(chains(), current, derived, reasons):
        findings, current = [*findings, *of_sizes(done)], corrected
        if done.absurd is not None:
            return findings, reasons
        try:
            drift = current_finding(done) if done.chain.of_positions else None
        except UNUSABLE as error:
            reasons.append(f"{done.chain.title} cannot be compared: {error}")
            continue
        findings += [] if drift is None else [drift]
    if not any(f.cause == "compass_deviation" and f.material for f in findings):
        try:
            pattern = deviation_finding(current, {f.cause for f in findings if f.material})
            findings += [] if pattern is None else [pattern]
        except UNUSABLE as error:
            reasons.append(f"the drift angle against the heading cannot be judged: {error}")
    return findings, reasons


def compared(
    along: Sequence[Chain], records: Sequence[Record], derived: Mapping[str, set[str]], reasons: list[str]
) -> Iterator[tuple[Compared, list[Record]]]:
    """Each chain's comparison, and the records corrected for what it and the ones before it found, until one finds an
    error that no instrument has.

    derived : as of `check_sensors`.  reasons : gets why some could not be compared.
    """
    current, earlier = list(records), frozenset[str]()
    for k, chain in enumerate(along):
        try:
            use, doubts = _as_velocities_were_made(chain, chain.taken(current), records)
            done = replace(compare(chain, use, derived, along[k + 1 :]), earlier=earlier)
            names = {r.name for r in done.records}
            current = [done.without(r) if r.name in names else r for r in current]
        except UNUSABLE as error:
            reasons.append(f"{chain.title} cannot be compared: {error}")
            continue
        reasons += [*doubts, *(f"{chain.title}: {why}" for why in done.reasons)]
        earlier |= {s.option.cause.id for s in done.sizes if s.material}
        yield done, current
        if done.absurd is not None:
            return


def _as_velocities_were_made(
    chain: Chain, current: Sequence[Record], originals: Sequence[Record]
) -> tuple[list[Record], list[str]]:
    """Records with the heading as it was given where a corrected one takes the track away from the velocities.

    They were then turned into body axes, or made from positions, with the heading as it is, and cannot judge it.
    """
    out, reasons = [], []
    before = {r.name: r for r in originals}
    for record in current:
        first = before[record.name]
        usable = HEADING in chain.integrated and why_not(chain, record) is None and why_not(chain, first) is None
        changed = usable and first.column(HEADING) is not record.column(HEADING)
        if changed and sums(chain, first, ()).square < sums(chain, record, ()).square:
            reasons.append(f"{chain.title}: in {record.name} velocities follow the heading with its error")
            record = record.with_channels(**{HEADING: first.column(HEADING)})
        out.append(record)
    return out, reasons
