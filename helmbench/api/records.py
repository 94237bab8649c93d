"""Records by themselves, and simulations beside them: check, validation; nothing is fitted."""

from __future__ import annotations

import warnings
from collections.abc import Mapping, Sequence
from dataclasses import replace
from os import PathLike, fspath
from typing import TYPE_CHECKING

from ..estimation.validation.result import Validation
from ..models.argument_types import typed
from ..models.errors import BadInput
from .arguments import admit, as_model, as_records, labels, listed, rudder_sign_doubt

if TYPE_CHECKING:
    from ..checks.result import Check, CheckFinding
    from ..datasets.io import Repairs
    from ..datasets.record import Record
    from ..models.model import Model
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


# ---- Validation.


@typed
def validate(
    model: Model | FilePath,
    records: Record | FilePath | Sequence[Record | FilePath],
    compare: Model | FilePath | Sequence[Model | FilePath] = (),
    *,
    positive_rudder: str | None = None,
) -> Validation:
    """Compare simulations with records: free runs, predictions some time ahead, manoeuvring indices.

    A free run starts from the state that the record itself, smoothed, has at its first sample, uses nothing of the
    record but rudder and revolutions, and has no random forces; it starts anew behind a long gap.  Errors of free runs
    are those of the recorded channels.  Predictions ahead start from up to 200 smoothed states of a record and are
    compared with what the hull did, behind the model's instruments.  The times ahead are 0.5, 1.5, 3, 6 and 12 ship
    lengths (10 to 249 s for a ship of 160 m at 15 kn) as far as a record is that long; where no model knows its length,
    sqrt(T / K) takes the place of L/U, else they are 1/60, 1/20 and 1/10 of the records' median duration.  A constant
    rate of turn and a constant heading stand beside the models: up to `trusted_s` a model is better.  The indices are
    those of IMO MSC.137(76), as far as the records allow them: overshoots of zigzags, advance, transfer and tactical
    diameter of turning circles, initial turning at 10 degrees of rudder; the simulated ship sails the same
    manoeuvre, with its own heading giving the counter rudder.

    Parameters
    ----------
    model : a model with coefficients, or a vessel id or the path of a model.json.
    records : one record or several, or paths of record files.
    compare : further models, likewise; they are validated in the same way.
    positive_rudder : 'port' or 'starboard', the side of a positive rudder in the files; overrides their sidecars.

    Warns
    -----
    RudderSignWarning : the yaw response of a record contradicts its rudder sign.

    Raises
    ------
    BadInput : a file or model cannot be used, a model has no coefficients, a record is given twice, no record suits the
        model, or the numbers of a record cannot be what they say.
    """
    from ..datasets.yaw_response import RudderSignWarning
    from ..estimation.validation import validate as engine

    models = _named_models(model, compare)
    given = as_records(records, positive_rudder)
    doubts = admit(given, next(iter(models.values())))
    named = dict(zip(_names([record.name for record in given], labels(records)), given, strict=True))
    found = replace(engine.validate(models, named), doubts=doubts)
    for doubt in filter(None, (rudder_sign_doubt(record, next(iter(models.values()))) for record in given)):
        warnings.warn(doubt, RudderSignWarning, stacklevel=3)
    return found


def _named_models(
    model: Model | FilePath, compare: Model | FilePath | Sequence[Model | FilePath]
) -> Mapping[str, Model]:
    """Models by identifier, or by what they were given as where identifiers repeat."""
    from ..models.model import Model

    given = [model, *listed(compare)]
    models = [as_model(one) for one in given]
    long = [one.id if isinstance(one, Model) else fspath(one) for one in given]
    return dict(zip(_names([one.id for one in models], long), models, strict=True))


def _names(short: Sequence[str], long: Sequence[str]) -> list[str]:
    """The short names if they differ, else the long ones; those that repeat even so get a number."""
    from ..estimation.records.naming import numbered

    return numbered(short if len(set(short)) == len(short) else long)
