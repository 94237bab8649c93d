"""A force over the variable that it depends on, where the records hold data."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import fields
from typing import TYPE_CHECKING

import numpy as np

from ..free_runs.motion import Motion
from ..result import Curve
from .forces import AXES, unit_of

if TYPE_CHECKING:
    from ...checks.result import Size
    from ..free_runs.problem import FreeRuns
    from .forces import Force

POINTS, ENDS, LAGS = 61, (1.0, 99.0), 5.0
"""Points of a curve, percentiles of the data that it ends at, and lags after a step that it ends after."""
VARIABLES = {
    "heading": ("heading", "rad"), "drift": ("v", "rad"), "yaw rate": ("r", "1"), "rudder angle": ("rudder", "rad"),
    "speed": ("speed", "m/s"), "time": ("time_s", "s"), "place to the north": ("north", "m"),
    "place to the east": ("east", "m"),
}  # fmt: skip
"""Variable -> its field of a motion, and its unit; the yaw rate in U/L."""


def curve_of(force: Force, runs: FreeRuns, numbers: Sequence[Size]) -> Curve | None:
    """The curve of a force with its band.

    Over the variable that it depends on; after a step of a motion, per unit of that, where it depends on the past; per
    unit of a motion over the time, where it grows with that; of a sensor's error over the time.  None where it depends
    on two variables, or a sensor's error is each record's own.

    numbers : of the force.
    """
    if any(size.record is not None for size in numbers):
        return None
    sizes = {size.parameter: (size.value, size.high - size.value) for size in numbers}
    first, longest_s = force.shape.depends_on[0], max(float(m.past_s[-1]) for m in runs.motions.values())
    time_s = np.linspace(0.0, longest_s, POINTS)
    if force.axis not in AXES:
        parts = {name: time_s if name.endswith("_drift") else np.ones(POINTS) for name in sizes}
        unit = force.unit(f"{force.axis}_first", runs.model)
        return _curve(("time", "s"), unit, time_s, parts, sizes)
    names = [name.format(force.axis).partition("@")[0] for name in force.shape.terms]
    unit = force.unit(names[0], runs.model)
    if first.startswith("past"):
        (lag_s,) = force.shape.settings
        after_s = np.linspace(0.0, LAGS * lag_s, POINTS)
        parts = {n: np.ones(POINTS) if n.endswith("_now") else 1.0 - np.exp(-after_s / lag_s) for n in names}
        return _curve(
            (f"time after a step of the {first.removeprefix('past of the ')}", "s"), unit, after_s, parts, sizes
        )
    if len(force.shape.depends_on) == 2 and first == "time":
        return _curve(("time", "s"), unit.removesuffix("/s"), time_s, {names[0]: time_s}, sizes)
    if len(force.shape.depends_on) == 2 or first not in VARIABLES:
        return None
    return _over_variable(force, runs, first, names, sizes)


def _over_variable(
    force: Force, runs: FreeRuns, variable: str, names: Sequence[str], sizes: Mapping[str, tuple[float, float]]
) -> Curve:
    """The curve over one variable, where the records hold data."""
    field, unit = VARIABLES[variable]
    motions = list(runs.motions.values())
    data = np.concatenate([getattr(m, "past_s" if field == "time_s" else field) for m in motions])
    if variable == "drift":
        data = np.arctan(-data)
    if variable == "heading":
        data = np.mod(data, 2.0 * np.pi)
    grid = np.linspace(*np.percentile(data, ENDS), POINTS)
    motion = _along(motions[0], field, np.tan(-grid) if variable == "drift" else grid)
    terms = zip(names, force.shape.terms.values(), strict=True)
    parts = {name: term(motion, force.axis) for name, term in terms}
    return _curve((variable, unit), unit_of(force.axis, runs.model), grid, parts, sizes)


def _curve(
    variable: tuple[str, str], unit: str, grid: np.ndarray, parts: Mapping[str, np.ndarray],
    sizes: Mapping[str, tuple[float, float]],
) -> Curve:  # fmt: skip
    """The sum of parts (N,) by number over a grid (N,) of a variable (name, unit), with its band."""
    values, halves = np.array([sizes[name] for name in parts]).T
    shapes = np.array(list(parts.values()))
    total, half = values @ shapes, np.sqrt(halves**2 @ shapes**2)
    return Curve(*variable, unit, *(tuple(column.tolist()) for column in (grid, total, total - half, total + half)))


def _along(motion: Motion, field: str, values: np.ndarray) -> Motion:
    """A motion at approach speed in which one field takes values (N,), all others being zero."""
    speed = float(np.median(motion.speed))
    pressure = np.full(values.size, motion.pressure[0] * speed**2 / motion.speed[0] ** 2)
    flat = {f.name: np.zeros(values.size) for f in fields(Motion) if f.name != "length_m"}
    flat |= {"time_s": np.linspace(0.0, 1.0, values.size), "speed": np.full(values.size, speed), "pressure": pressure}
    return Motion(**flat | {field: values}, length_m=motion.length_m)
