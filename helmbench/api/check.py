"""Check of records without a model."""

from __future__ import annotations

from collections.abc import Sequence
from os import PathLike
from typing import TYPE_CHECKING

from ..models.argument_types import typed
from ..models.errors import BadInput
from .arguments import listed

if TYPE_CHECKING:
    from ..checks.result import Check, CheckFinding
    from ..datasets.io import Repairs
    from ..datasets.record import Record
    from .arguments import Path as FilePath


@typed
def check(records: Record | FilePath | Sequence[Record | FilePath], *, positive_rudder: str | None = None) -> Check:
    """Check what records show of their sensors and files, without a model of the ship.

    Time stamps, frozen samples, jumps, units, signs, exchanged columns, channels made from each other, outliers; then
    heading against yaw rate and positions against velocities, for biases, scales, delays, offsets and currents.  What
    cannot be computed is said in `not_checked`.

    Parameters
    ----------
    records : records, or paths of record files.  A file may have time stamps that repeat or go back.
    positive_rudder : 'port' or 'starboard', the side of a positive rudder in the files; overrides their sidecars.

    Raises
    ------
    BadInput : no record is given, or a file cannot be read as a table with known columns.
    """
    from ..checks.check import check as engine

    given = [_read(one, positive_rudder) for one in listed(records)]
    if not given:
        raise BadInput("no record to check", hint="give one record or more")
    return engine([record for record, _ in given], [f for _, found in given for f in found])


def _read(one: Record | FilePath, positive_rudder: str | None) -> tuple[Record, list[CheckFinding]]:
    """A record, and what was wrong with its file."""
    if not isinstance(one, str | PathLike):
        return one, []
    from ..datasets.io import read_leniently

    record, repairs = read_leniently(one, positive_rudder)
    return record, _of_repairs(record, repairs)


def _of_repairs(record: Record, repairs: Repairs) -> list[CheckFinding]:
    """Findings about rows that were left out or moved on reading."""
    from ..checks.base import Fault, of_fault
    from ..checks.registry import check_of

    said = {
        "have no time": repairs.timeless,
        "repeat the time of another row (the first was kept)": repairs.repeated,
        "stand before an earlier time (they were put in order)": repairs.backwards,
    }
    faults = [Fault(f"{n} of {repairs.rows} rows {what}", ("time_s",)) for what, n in said.items() if n]
    faults += [Fault(f"{name} has {n} infinite values", (name,)) for name, n in repairs.infinite]
    return [of_fault(check_of("time_stamps"), fault, record) for fault in faults]
