"""A force over the variable that it depends on, where the records hold data."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import fields
from typing import TYPE_CHECKING

import numpy as np

from ..free_runs.motion import Motion
from ..result import Curve
from .forces import AXES, unit_of

if TYPE_CHECKING:
    from ..free_runs.problem import FreeRuns
    from .forces import Force

POINTS, ENDS = 61, (1.0, 99.0)
"""Points of a curve, and percentiles of the data that it ends at."""
VARIABLES = {
    "heading": ("heading", "rad"), "drift": ("v", "rad"), "yaw rate": ("r", "1"), "rudder angle": ("rudder", "rad"),
    "speed": ("speed", "m/s"), "time": ("time_s", "s"), "place to the north": ("north", "m"),
    "place to the east": ("east", "m"),
}  # fmt: skip
"""Variable -> its field of a motion, and its unit; the yaw rate in U/L."""


def curve_of(force: Force, runs: FreeRuns, sizes: Mapping[str, tuple[float, float]]) -> Curve | None:
    """The curve of a force with its band; None where it depends on more than one variable, or on the past of one.

    sizes : number -> value, and half of its 90 % interval.
    """
    variable = "".join(force.shape.depends_on)
    if force.axis not in AXES or variable not in VARIABLES:
        return None
    field, unit = VARIABLES[variable]
    motions = list(runs.motions.values())
    data = np.concatenate([getattr(m, "past_s" if field == "time_s" else field) for m in motions])
    if variable == "drift":
        data = np.arctan(-data)
    if variable == "heading":
        data = np.mod(data, 2.0 * np.pi)
    grid = np.linspace(*np.percentile(data, ENDS), POINTS)
    motion = _along(motions[0], field, np.tan(-grid) if variable == "drift" else grid)
    parts = [term(motion, force.axis) for term in force.shape.terms.values()]
    names = [name.format(force.axis).partition("@")[0] for name in force.shape.terms]
    values, halves = np.array([sizes[n] for n in names]).T
    total = values @ np.array(parts)
    half = np.sqrt(halves**2 @ np.array(parts) ** 2)
    columns = (tuple(column.tolist()) for column in (grid, total, total - half, total + half))
    return Curve(variable, unit, unit_of(force.axis, runs.model), *columns)


def _along(motion: Motion, field: str, values: np.ndarray) -> Motion:
    """A motion at approach speed in which one field takes values (N,), all others being zero."""
    speed = float(np.median(motion.speed))
    pressure = np.full(values.size, motion.pressure[0] * speed**2 / motion.speed[0] ** 2)
    flat = {f.name: np.zeros(values.size) for f in fields(Motion) if f.name != "length_m"}
    flat |= {"time_s": np.linspace(0.0, 1.0, values.size), "speed": np.full(values.size, speed), "pressure": pressure}
    return Motion(**flat | {field: values}, length_m=motion.length_m)
