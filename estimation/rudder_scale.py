"""Whether a model follows its records far better with half or twice the rudder: then the column holds another angle."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from ..checks.result import CheckFinding, Size
from ..models.errors import CannotFit
from .free_run import squares
from .series import series_of

if TYPE_CHECKING:
    from ..datasets.record import Record
    from ..models.model import Model

FACTORS = (0.25, 0.33, 0.4, 0.45, 0.5, 0.55, 0.62, 0.75, 1.0, 1.33, 1.6, 1.8, 2.0, 2.2, 2.5, 3.0, 4.0)
"""Factors on the rudder that are tried."""
UNITS = {0.45: "twice", 0.5: "twice", 0.55: "twice", 1.8: "half", 2.0: "half", 2.2: "half"}
"""Factors that no hull's error explains: the column holds twice, or half, the angle."""
FALL = 0.3
"""Share of the squared error of free runs that may be left with another factor."""
RUDDERS = ("rudder_rad", "rudder_command_rad")


def rudder_doubt(records: Sequence[Record], model: Model) -> CheckFinding | None:
    """A finding that stands where free runs with half or twice the rudder follow the yaw motion far better; else None.

    records : in the model's sign of the rudder, behind its instruments.
    """
    if not model.known:
        return None
    with np.errstate(all="ignore"):
        errors = {factor: _yaw_error(records, model, factor) for factor in FACTORS}
    best = min(errors, key=lambda factor: errors[factor])
    if best not in UNITS or not errors[best] < FALL * errors[1.0]:
        return None
    left = 100.0 * errors[best] / errors[1.0] if np.isfinite(errors[1.0]) else 0.0
    said = (
        f"the rudder is {UNITS[best]} what the yaw rate shows: with {best:g} times the angle {left:.0f} % of the "
        f"squared error of free runs of {model.id} are left"
    )
    names, size = tuple(r.name for r in records), Size("factor", best, best, best, "1")
    return CheckFinding("wrong_unit", "file", names, ("rudder_rad",), (size,), said, standing=True)


def _with_rudder(record: Record, factor: float) -> Record:
    """The record with its rudder angles multiplied."""
    return record.with_channels(**{n: factor * record.column(n) for n in RUDDERS if record.has(n)})


def _yaw_error(records: Sequence[Record], model: Model, factor: float) -> float:
    """Squared error of free runs, in units of the yaw motion, summed over the records."""
    total = 0.0
    for record in records:
        symbol = "r" if record.has("yaw_rate_rad_s") else "psi"
        try:
            series = series_of(_with_rudder(record, factor), model, (symbol,))
        except CannotFit:
            continue
        motion = float(np.nansum((series.outputs - np.nanmean(series.outputs)) ** 2))
        error = float(squares(model, series, series.start)[0])
        total += error / max(motion, 1e-300)
    return total
