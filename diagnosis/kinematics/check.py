"""`check`: what sensors and files show without a hull model.

First the file of each record (stamps, frozen samples, jumps, units, signs, exchanged columns, copies, outliers), then
sensors, on records with gross faults put right: heading against yaw rate, then positions against velocities.  Nothing
here knows a vessel, so no fault of a model can appear as one of a sensor.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from ...models.errors import BadInput, CannotFit
from ..causes.registry import cause, check_causes
from .chains import Chain, heading_chain, track_chain
from .check_result import CheckFinding, CheckResult
from .fault import Fault, cleaned
from .findings import merged, of_drift, of_fault, of_sizes
from .outlying import without_outliers
from .sensors import Compared, compare

if TYPE_CHECKING:
    from ...datasets.record import Record

UNUSABLE = (BadInput, CannotFit, ArithmeticError, ValueError, IndexError, np.linalg.LinAlgError)
"""What a computation on records that cannot carry it may raise."""


def check(records: Sequence[Record], given: Iterable[CheckFinding] = ()) -> CheckResult:
    """Check records without a model.

    given : findings that were made on reading the files.
    """
    records = _distinct(records)
    names = tuple(r.name for r in records)
    file_findings, reasons, sound, tied = list(given), [], [], {}
    with np.errstate(all="ignore"):
        for record in records:
            found, why, put_right, derived = check_file(record)
            file_findings += found
            reasons += why
            sound.append(put_right)
            tied[record.name] = derived
        sensor_findings, why = check_sensors(sound, tied)
    return CheckResult(names, (*merged(file_findings), *sensor_findings), tuple([*reasons, *why]))


def _distinct(records: Sequence[Record]) -> list[Record]:
    """The records under names that differ."""
    out: list[Record] = []
    for record in records:
        taken = {r.name for r in out}
        numbers = (f"{record.name} ({i})" for i in range(2, len(records) + 2))
        name = record.name if record.name not in taken else next(n for n in numbers if n not in taken)
        out.append(replace(record, name=name))
    return out


def check_file(record: Record) -> tuple[list[CheckFinding], list[str], Record, set[str]]:
    """Findings of one record's file, what could not be checked, the record put right as far as possible, and the
    columns that cannot check each other."""
    found: list[CheckFinding] = []
    reasons: list[str] = []
    derived: set[str] = set()
    for name in ORDER:
        entry = check_causes()[name]
        try:
            faults = entry.find(record)
        except UNUSABLE as error:
            reasons.append(f"{name} of {record.name} cannot be looked for: {error}")
            continue
        found += [of_fault(entry, fault, record) for fault in faults]
        derived |= {c for f in faults if name == "derived_channel" and f.material for c in f.channels}
        record = cleaned(record, faults)
    for look in (_exchanged, _outlying):
        try:
            more, record = look(record)
            found += more
        except UNUSABLE as error:
            reasons.append(f"exchanged columns and outliers of {record.name} cannot be looked for: {error}")
    return found, reasons, record, derived


SIDES = (
    "a positive rudder is to turn the ship to {}, and it turns to the other side (z = {:.0f}): the sign is wrong, or "
    "port and starboard (left and right thrust) are exchanged"
)
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
"""Order in which faults of a file are looked for: each on what the ones before have put right."""


def _exchanged(record: Record) -> tuple[list[CheckFinding], Record]:
    """Exchanged columns, velocities of the earth frame, a rudder that steers to the other side."""
    found = []
    for name in ("channel_swap", "earth_frame_velocity", "rudder_sign"):
        entry = cause(name)
        side = record.meta.positive_rudder
        if name == "rudder_sign" and (
            side is None or not any(record.has(n) for n in ("rudder_rad", "rudder_command_rad"))
        ):
            continue
        faults, (record,) = entry.find([record], 1.0 if side == "starboard" else -1.0)  # type: ignore[attr-defined]
        for fault in faults:
            said = fault.evidence
            if name == "rudder_sign":
                said = SIDES.format(side, np.sqrt(fault.statistic))
            columns = tuple(fault.details.get("channels", ()))
            found.append(of_fault(entry, Fault(said, columns), record))
    return found, record


def _outlying(record: Record) -> tuple[list[CheckFinding], Record]:
    faults, record = without_outliers(record)
    return [of_fault(cause("outliers"), fault, record) for fault in faults], record


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
        done = compare(chain, use)
        reasons += [f"{chain.title}: {why}" for why in done.reasons]
        found += of_sizes(done)
        if chain.target == ("north_m", "east_m") and done.records:
            found += of_drift(done)
        current = _merged(current, done)
    return found, reasons


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
    """The records, those that were compared as put right."""
    fixed = {r.name: r for r in done.corrected}
    return [fixed.get(r.name, r) for r in records]
