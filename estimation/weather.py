"""Measured wind as an input of free runs: where a record has it and the vessel has windage."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from ..datasets.record import Record
    from ..models.model import Model
    from .series import Series

SPEED, FROM = "wind_speed_m_s", "wind_direction_rad"


def measured_weather(record: Record, model: Model, grid: np.ndarray) -> np.ndarray | None:
    """Inputs (M, 7) of the model's environment variant at the times `grid` (M,) of equal steps, s.

    Current, wind velocity north and east [m/s, towards], forces: all zero but the wind, which is the mean of the record
    over one step.  None without windage, without both columns, or where either has no sample.
    """
    half = 0.5 * (grid[1] - grid[0]) if grid.size > 1 else 0.5
    wind = _mean_wind(record, model, grid - half, grid + half)
    if wind is None:
        return None
    return np.hstack([np.zeros((grid.size, 2)), wind, np.zeros((grid.size, 3))])


def held_weather(record: Record, model: Model, time_s: np.ndarray) -> np.ndarray:
    """Current and wind velocity (M, 4), north and east [m/s, towards], that a filter holds from each of the times (M,)
    to the next one: zero but for the wind, which is the mean of the record over that step."""
    out = np.zeros((time_s.size, 4))
    wind = _mean_wind(record, model, time_s[:-1], time_s[1:]) if time_s.size > 1 else None
    if wind is not None:
        out[:-1, 2:], out[-1, 2:] = wind, wind[-1]
    return out


def with_wind(series: Series, record: Record, model: Model) -> Series:
    """The series with the inputs of the model's environment variant behind its own, where wind counts.

    record : the record that the series was made of, or one of more samples that it was thinned from.
    """
    grid = record.time_s[0] + series.dt * np.arange(len(series.inputs))
    weather = measured_weather(record, model, grid)
    return series if weather is None else replace(series, inputs=np.hstack([series.inputs, weather]))


def _mean_wind(record: Record, model: Model, low: np.ndarray, high: np.ndarray) -> np.ndarray | None:
    """Mean wind (M, 2), north and east [m/s, towards], from each time `low` (M,) to `high` (M,), s."""
    if model.windage is None or not model.is_3dof or not (record.has(SPEED) and record.has(FROM)):
        return None
    speed, direction = record.column(SPEED), record.column(FROM)
    known = np.isfinite(speed) & np.isfinite(direction)
    if not known.any():
        return None
    parts = np.cos(direction[known]), np.sin(direction[known])
    return np.column_stack([_means(record.time_s[known], -speed[known] * part, low, high) for part in parts])


def _means(time: np.ndarray, values: np.ndarray, low: np.ndarray, high: np.ndarray) -> np.ndarray:
    """Means (M,) of a series (N,), linear between its samples and constant beyond, from `low` (M,) to `high` (M,)."""
    time = np.concatenate([[min(low[0], time[0])], time, [max(high[-1], time[-1])]])
    values = np.concatenate([values[:1], values, values[-1:]])
    area = np.concatenate([[0.0], np.cumsum(0.5 * (values[1:] + values[:-1]) * np.diff(time))])
    return (_area(high, time, area, values) - _area(low, time, area, values)) / (high - low)


def _area(at: np.ndarray, time: np.ndarray, area: np.ndarray, values: np.ndarray) -> np.ndarray:
    """Integral (M,) of the series up to the times `at` (M,)."""
    k = np.clip(np.searchsorted(time, at, side="right") - 1, 0, time.size - 2)
    ahead, step = at - time[k], np.maximum(time[k + 1] - time[k], 1e-300)
    return area[k] + ahead * (values[k] + 0.5 * ahead / step * (values[k + 1] - values[k]))
