"""Whether the rudder's column holds another angle: beyond the ship's stops, or a model follows its records far better
with half or twice of it."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from ...checks.result import CheckFinding, Size
from ...datasets.columns import RUDDERS
from ...models.errors import CannotFit
from ..records.series import Series, series_of
from ..simulation.free_run import squares

if TYPE_CHECKING:
    from ...datasets.record import Record
    from ...models.model import Model

FACTORS = (0.25, 0.33, 0.4, 0.45, 0.5, 0.55, 0.62, 0.75, 1.0, 1.33, 1.6, 1.8, 2.0, 2.2, 2.5, 3.0, 4.0)
"""Factors on the rudder that are tried."""
TWICE, HALF = 0.55, 1.8
"""Factors up to and from which no hull's error explains them: the column holds twice the angle or more, or half or
less."""
FALL = 0.3
"""Share of the squared error of free runs that may be left with another factor."""
LOST = 0.2
"""Share of the yaw motion that free runs with the column as it is must lose, and that those with the factor must not:
they follow."""
SWAY = (-0.6, -0.3, 0.0, 0.3, 0.6)
"""Sway at the start of a record that does not measure it, in units of its largest yaw rate times the length: it may
begin between the turns of a zigzag."""
SHORTEST = 3.0
"""Ship lengths of sailing below which the motion is that of the start."""
BEYOND, USUAL = 1.1, 0.98
"""Times the angle of the stops that a column must reach, and the share of the samples that may lie further out."""


def rudder_doubt(records: Sequence[Record], model: Model) -> CheckFinding | None:
    """A finding that stands where the rudder goes far beyond the model's stops, or where free runs with half or twice
    the rudder follow the yaw motion far better; else None.

    records : in the model's sign of the rudder, behind its instruments.
    """
    return _beyond_stops(records, model) or _other_angle(records, model)


def _beyond_stops(records: Sequence[Record], model: Model) -> CheckFinding | None:
    steered = [r for r in records if any(r.has(name) for name in RUDDERS) and np.isfinite(r.rudder()).any()]
    most = {r.name: float(np.nanquantile(np.abs(r.rudder()), USUAL)) for r in steered}
    names = tuple(name for name, angle in most.items() if angle > BEYOND * model.rudder.max_rad)
    if not names:
        return None
    largest = max(most[name] for name in names)
    said = (
        f"the rudder reaches {np.rad2deg(largest):.3g} deg, beyond the stops of {model.id} at "
        f"{np.rad2deg(model.rudder.max_rad):.3g} deg: another unit or scale, or another ship"
    )
    factor = float(model.rudder.max_rad / largest)
    size = Size("factor", factor, factor, factor, "1")
    return CheckFinding("wrong_unit", "file", names, ("rudder_rad",), (size,), said, standing=True)


def _other_angle(records: Sequence[Record], model: Model) -> CheckFinding | None:
    if not model.known:
        return None
    with np.errstate(all="ignore"):
        errors = {factor: _yaw_error(records, model, factor) for factor in FACTORS}
    best = min(errors, key=lambda factor: errors[factor])
    if TWICE < best < HALF or not errors[best] < FALL * errors[1.0] or not errors[best] < LOST < errors[1.0]:
        return None
    left = 100.0 * errors[best] / errors[1.0] if np.isfinite(errors[1.0]) else 0.0
    said = (
        f"the rudder is {'twice' if best <= TWICE else 'half'} what the yaw rate shows, or so: with {best:g} times the "
        f"angle {left:.0f} % of the squared error of free runs of {model.id} are left"
    )
    names, size = tuple(r.name for r in records), Size("factor", best, best, best, "1")
    return CheckFinding("wrong_unit", "free runs", names, ("rudder_rad",), (size,), said, standing=True)


def _with_rudder(record: Record, factor: float) -> Record:
    """The record with its rudder angles multiplied."""
    return record.with_channels(**{n: factor * record.column(n) for n in RUDDERS if record.has(n)})


def _starts(record: Record, model: Model, series: Series, symbol: str) -> list[np.ndarray]:
    """Initial states (n,) that the record leaves open."""
    if "v" not in model.states or record.has("sway_m_s") or symbol != "r":
        return [series.start]
    most = float(np.nanmax(np.abs(series.outputs))) * model.particulars.get("L", 0.0)
    sway = np.eye(len(series.start))[model.states.index("v")]
    return [series.start + part * most * sway for part in SWAY]


def _yaw_error(records: Sequence[Record], model: Model, factor: float) -> float:
    """Squared error of free runs, in units of the yaw motion, mean over the records."""
    errors = []
    length = model.particulars.get("L", 0.0)
    for record in records:
        if (record.time_s[-1] - record.time_s[0]) * model.speed_m_s < SHORTEST * length:
            continue
        symbol = "r" if record.has("yaw_rate_rad_s") else "psi"
        try:
            series = series_of(_with_rudder(record, factor), model, (symbol,))
        except CannotFit:
            continue
        motion = float(np.nansum((series.outputs - np.nanmean(series.outputs)) ** 2))
        starts = _starts(record, model, series, symbol)
        error = min(float(squares(model, series, start)[0]) for start in starts)
        errors.append(error / max(motion, 1e-300))
    return float(np.mean(errors)) if errors else 0.0
