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
    if model.windage is None or not model.is_3dof or not (record.has(SPEED) and record.has(FROM)):
        return None
    speed, direction = record.column(SPEED), record.column(FROM)
    known = np.isfinite(speed) & np.isfinite(direction)
    if not known.any():
        return None
    weather = np.zeros((grid.size, 7))
    time = record.time_s[known]
    for column, part in ((2, np.cos(direction[known])), (3, np.sin(direction[known]))):
        weather[:, column] = _means(time, -speed[known] * part, grid)
    return weather


def with_wind(series: Series, record: Record, model: Model) -> Series:
    """The series with the inputs of the model's environment variant behind its own, where wind counts.

    record : the record that the series was made of, or one of more samples that it was thinned from.
    """
    grid = record.time_s[0] + series.dt * np.arange(len(series.inputs))
    weather = measured_weather(record, model, grid)
    return series if weather is None else replace(series, inputs=np.hstack([series.inputs, weather]))


def _means(time: np.ndarray, values: np.ndarray, grid: np.ndarray) -> np.ndarray:
    """Means (M,) of a series (N,), linear between its samples and constant beyond, over a step about each grid time."""
    half = 0.5 * (grid[1] - grid[0]) if grid.size > 1 else 0.5
    ends = np.array([min(grid[0], time[0]) - half, max(grid[-1], time[-1]) + half])
    time = np.concatenate([ends[:1], time, ends[1:]])
    values = np.concatenate([values[:1], values, values[-1:]])
    area = np.concatenate([[0.0], np.cumsum(0.5 * (values[1:] + values[:-1]) * np.diff(time))])
    return (np.interp(grid + half, time, area) - np.interp(grid - half, time, area)) / (2.0 * half)
