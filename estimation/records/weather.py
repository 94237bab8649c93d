"""Measured wind and current as inputs of free runs: current of a 3-DOF model, wind where it has windage too."""

from __future__ import annotations

import numpy as np

from ...datasets.record import Record
from ...models.model import Model

CURRENT = ("current_speed_m_s", "current_direction_rad", 1.0)
WIND = ("wind_speed_m_s", "wind_direction_rad", -1.0)
"""Columns of speed and direction, and the sign towards: a current is told by where it flows to, a wind by where it
blows from."""


def measured_weather(record: Record, model: Model, grid: np.ndarray) -> np.ndarray | None:
    """Inputs (M, 7) of the model's environment variant at the times `grid` (M,) of equal steps, s.

    Current and wind velocity, north and east [m/s, towards], as means of the record over one step; no forces.  None
    where the record has neither: wind counts for a vessel with windage, both need speed and direction.
    """
    half = 0.5 * (grid[1] - grid[0]) if grid.size > 1 else 0.5
    flows = _mean_flows(record, model, grid - half, grid + half)
    return None if flows is None else np.hstack([flows, np.zeros((grid.size, 3))])


def held_weather(record: Record, model: Model, time_s: np.ndarray) -> np.ndarray:
    """Current and wind velocity (M, 4), north and east [m/s, towards], that a filter holds from each of the times (M,)
    to the next one: means of the record over that step, zero where it measures neither."""
    out = np.zeros((time_s.size, 4))
    flows = _mean_flows(record, model, time_s[:-1], time_s[1:]) if time_s.size > 1 else None
    if flows is not None:
        out[:-1], out[-1] = flows, flows[-1]
    return out


def flow_of(record: Record, columns: tuple[str, str, float]) -> tuple[np.ndarray, np.ndarray] | None:
    """Times (K,) and velocity (K, 2), north and east [m/s, towards], of a measured flow; None where it has no
    sample."""
    speed_name, direction_name, sign = columns
    if not (record.has(speed_name) and record.has(direction_name)):
        return None
    speed, direction = record.column(speed_name), record.column(direction_name)
    known = np.isfinite(speed) & np.isfinite(direction)
    if not known.any():
        return None
    towards = np.column_stack([np.cos(direction[known]), np.sin(direction[known])])
    return record.time_s[known], sign * speed[known, None] * towards


def _mean_flows(record: Record, model: Model, low: np.ndarray, high: np.ndarray) -> np.ndarray | None:
    """Mean current and wind (M, 4) from each time `low` (M,) to `high` (M,), s."""
    if not model.is_3dof:
        return None
    found = [flow_of(record, CURRENT), flow_of(record, WIND) if model.windage is not None else None]
    if found == [None, None]:
        return None
    out = np.zeros((low.size, 4))
    for place, flow in zip((0, 2), found, strict=True):
        if flow is not None:
            time, velocity = flow
            out[:, place] = _means(time, velocity[:, 0], low, high)
            out[:, place + 1] = _means(time, velocity[:, 1], low, high)
    return out


def _means(time: np.ndarray, values: np.ndarray, low: np.ndarray, high: np.ndarray) -> np.ndarray:
    """Means (M,) of a series (N,), linear between its samples and constant beyond, from `low` (M,) to `high` (M,)."""
    from scipy.interpolate import make_interp_spline

    time = np.concatenate([[min(low[0], time[0] - 1.0)], time, [max(high[-1], time[-1] + 1.0)]])
    area = make_interp_spline(time, np.concatenate([values[:1], values, values[-1:]]), k=1).antiderivative()
    return (area(high) - area(low)) / (high - low)
