"""`check`: what sensors and files show without a hull model.

First the file of each record (stamps, frozen samples, jumps, units, signs, exchanged columns, copies, outliers), then
sensors, on records with gross faults corrected: heading against yaw rate, then positions against velocities.  Nothing
here knows a vessel, so no fault of a model can appear as one of a sensor.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from ..datasets.record import RUDDERS
from ..models.errors import BadInput, CannotFit
from .comparison.chains import Chain, heading_chain, sums, track_chain, why_not
from .comparison.courses import deviation
from .comparison.selection import Compared, compare
from .fault import Fault, cleaned
from .findings import merged, of_deviation, of_drift, of_fault, of_sizes
from .integrity.outlying import without_outliers
from .registry import check_of, column_checks, file_checks
from .result import CheckFinding, CheckResult

if TYPE_CHECKING:
    from ..datasets.record import Record

HEADING = "heading_rad"
UNUSABLE = (BadInput, CannotFit, ArithmeticError, ValueError, IndexError, np.linalg.LinAlgError)
"""What a computation on records that cannot carry it may raise."""


def check(records: Sequence[Record], given: Iterable[CheckFinding] = ()) -> CheckResult:
    """Check records without a model.

    given : findings that were made on reading the files.
    """
    records = distinct(records)
    names = tuple(r.name for r in records)
    file_findings, reasons, sound, tied = list(given), [], [], {}
    with np.errstate(all="ignore"):
        for record in records:
            found, why, corrected, derived = check_file(record)
            file_findings += found
            reasons += why
            sound.append(corrected)
            tied[record.name] = derived
        turned, sound, why = check_rudder(sound)
        file_findings += turned
        reasons += why
        sensor_findings, why = check_sensors(sound, tied)
    return CheckResult(names, (*merged(file_findings), *sensor_findings), tuple([*reasons, *why]))


def distinct(records: Sequence[Record]) -> list[Record]:
    """The records under names that differ."""
    out: list[Record] = []
    for record in records:
        taken = {r.name for r in out}
        numbers = (f"{record.name} ({i})" for i in range(2, len(records) + 2))
        name = record.name if record.name not in taken else next(n for n in numbers if n not in taken)
        out.append(replace(record, name=name))
    return out


def check_file(record: Record) -> tuple[list[CheckFinding], list[str], Record, set[str]]:
    """Findings of one record's file, what could not be checked, the record corrected as far as possible, and the
    columns that cannot check each other."""
    found, reasons, record, derived = file_faults(record, ORDER)
    for look in (_exchanged, _outlying):
        try:
            more, record = look(record)
            found += more
        except UNUSABLE as error:
            reasons.append(f"exchanged columns and outliers of {record.name} cannot be looked for: {error}")
    return found, reasons, record, derived


def file_faults(record: Record, names: Iterable[str]) -> tuple[list[CheckFinding], list[str], Record, set[str]]:
    """The same of the causes named alone, each on what the ones before have corrected."""
    found: list[CheckFinding] = []
    reasons: list[str] = []
    derived: set[str] = set()
    for name in names:
        entry = file_checks()[name]
        try:
            faults = entry.find(record)
        except UNUSABLE as error:
            reasons.append(f"{name} of {record.name} cannot be looked for: {error}")
            continue
        found += [of_fault(entry, fault, record) for fault in faults]
        derived |= {c for f in faults if name == "derived_channel" and f.material for c in f.channels}
        record = cleaned(record, faults)
    return found, reasons, record, derived


SIDES = (
    "a positive rudder is to turn the ship to {}, and it turns to the other side (z = {:.0f}): the sign is wrong, or "
    "port and starboard (left and right thrust) are exchanged"
)
EXCHANGED = ("channel_swap", "earth_frame_velocity")
ORDER = (
    "constant_channel",
    "time_stamps",
    "frozen_samples",
    "coarse_channel",
    "wrong_unit",
    "channel_sign",
    "splice",
    "derived_channel",
    "rudder_from_sensor",
)
"""Order in which faults of a file are looked for: each on what the ones before have corrected."""


def _exchanged(record: Record) -> tuple[list[CheckFinding], Record]:
    """Exchanged columns, and velocities of the earth frame."""
    found = []
    for entry in (e for e in column_checks() if e.id in EXCHANGED):
        faults, (record,) = entry.find([record], 1.0)
        found += [of_fault(entry, Fault(f.evidence, tuple(f.details.get("channels", ()))), record) for f in faults]
    return found, record


def check_rudder(records: Sequence[Record]) -> tuple[list[CheckFinding], list[Record], list[str]]:
    """A rudder that steers to the other side than the records say: all records of a side together."""
    found, out, reasons = [], list(records), []
    entry = next(e for e in column_checks() if e.id == "rudder_sign")
    for side, starboard in (("starboard", 1.0), ("port", -1.0)):
        group = [i for i, r in enumerate(out) if r.meta.positive_rudder == side and any(map(r.has, RUDDERS))]
        for own in (group, *([i] for i in group if len(group) > 1)):
            try:
                faults, fixed = entry.find([out[i] for i in own], starboard)
            except UNUSABLE as error:
                reasons.append(f"the side of the rudder cannot be checked: {error}")
                continue
            for fault in faults:
                said = Fault(SIDES.format(side, np.sqrt(fault.statistic)), RUDDERS)
                found += [replace(of_fault(entry, said, records[own[0]]), records=tuple(records[i].name for i in own))]
            for i, record in zip(own, fixed, strict=True):
                out[i] = record
    return found, out, reasons


def _outlying(record: Record) -> tuple[list[CheckFinding], Record]:
    faults, record = without_outliers(record)
    return [of_fault(check_of("outliers"), fault, record) for fault in faults], record


def check_sensors(records: Sequence[Record], derived: dict[str, set[str]]) -> tuple[list[CheckFinding], list[str]]:
    """Sensor errors of records that are free of gross faults, and why some could not be compared.

    derived : record name -> columns that are made from each other: they are not compared.
    """
    found: list[CheckFinding] = []
    reasons: list[str] = []
    current = list(records)
    for chain in (heading_chain(), track_chain()):
        use, skipped = _split(chain, current, derived)
        reasons += skipped
        try:
            use, doubts = _as_velocities_were_made(chain, use, records)
            reasons += doubts
            done = compare(chain, use)
            found += of_sizes(done)
            found += of_drift(done) if chain.target == ("north_m", "east_m") and done.records else []
        except UNUSABLE as error:
            reasons.append(f"{chain.title} cannot be compared: {error}")
            continue
        reasons += [f"{chain.title}: {why}" for why in done.reasons]
        current = _merged(current, done)
    if not any(f.cause == "compass_deviation" and f.material for f in found):
        try:
            found += of_deviation(deviation(current))
        except UNUSABLE as error:
            reasons.append(f"the drift angle against the heading cannot be judged: {error}")
    return found, reasons


def _as_velocities_were_made(
    chain: Chain, current: Sequence[Record], given: Sequence[Record]
) -> tuple[list[Record], list[str]]:
    """Records with the heading as it was given where a corrected one takes the track away from the velocities.

    They were then turned into body axes, or made from positions, with the heading as it is, and cannot judge it.
    """
    out, reasons = [], []
    before = {r.name: r for r in given}
    for record in current:
        first = before[record.name]
        usable = HEADING in chain.integrated and why_not(chain, record) is None and why_not(chain, first) is None
        changed = usable and first.column(HEADING) is not record.column(HEADING)
        if changed and sums(chain, first, ()).square < sums(chain, record, ()).square:
            reasons.append(f"{chain.title}: in {record.name} velocities follow the heading with its error")
            record = record.with_channels(**{HEADING: first.column(HEADING)})
        out.append(record)
    return out, reasons


def _split(chain: Chain, records: Sequence[Record], derived: dict[str, set[str]]) -> tuple[list[Record], list[str]]:
    """Records whose columns can check each other, and a sentence for each that cannot."""
    use, reasons = [], []
    for record in records:
        made = derived.get(record.name, set())
        if made >= set(chain.opposed):
            reasons.append(
                f"{chain.title}: in {record.name} one is made from the other, so they cannot check each other"
            )
        else:
            use.append(record)
    return use, reasons


def _merged(records: Sequence[Record], done: Compared) -> list[Record]:
    """The records, those that were compared as corrected."""
    fixed = {r.name: r for r in done.corrected}
    return [fixed.get(r.name, r) for r in records]
