"""Whether the rudder's column holds another angle: beyond the ship's stops, or a model follows its records far better
with half or twice of it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from functools import partial
from typing import TYPE_CHECKING

import numpy as np

from ...checks.result import CheckFinding, Size
from ...datasets.columns import RUDDERS
from ...models.errors import CannotFit
from ..run.run import run_of
from ..run.start import start_state
from ..run.stretch import stretches_of

if TYPE_CHECKING:
    from ...datasets.record import Record
    from ...models.model import Model
    from ..run.stretch import FreeRun, Stretch

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
YAW = ("yaw_rate_rad_s", "heading_rad")
"""Channels of which the first that a record has tells the yaw motion."""
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
    errors = _yaw_errors(records, model)
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


def _yaw_errors(records: Sequence[Record], model: Model) -> dict[float, float]:
    """Factor on the rudder -> squared error of free runs, in units of the yaw motion, mean over the records."""
    errors: dict[float, list[float]] = {factor: [] for factor in FACTORS}
    length, model = model.particulars.get("L", 0.0), replace(model, instruments={})
    for record in records:
        if (record.time_s[-1] - record.time_s[0]) * model.speed_m_s < SHORTEST * length:
            continue
        try:
            stretches = stretches_of(model, record)
        except CannotFit:
            continue
        for factor, own in errors.items():
            run = run_of(stretches, record, model.id, record.name, partial(_with_rudder, factor=factor))
            yaw = next((c for c in YAW if c in run.predicted), None)
            own += [] if yaw is None else [1.0 - run.squares()[yaw].scores()[1]]
    return {factor: float(np.mean(own)) if own else 0.0 for factor, own in errors.items()}


def _with_rudder(stretch: Stretch, factor: float) -> FreeRun:
    """The free run with the rudder angles multiplied, from where it then starts."""
    inputs = stretch.series.inputs.copy()
    inputs[:, 0] *= factor
    return stretch.run(
        start_state(stretch.model, stretch.series.start, stretch.known, inputs, stretch.series.dt), inputs
    )
