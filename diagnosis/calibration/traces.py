"""Measured channels of training records against free runs before and after the calibration, for pages and figures."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING

import numpy as np

from ..free_runs.problem import Lane
from ..free_runs.units import names_of_units
from ..trace import Trace
from .whole_records import columns_of_states

if TYPE_CHECKING:
    from ..free_runs.problem import FreeRuns
    from .attempts import Attempt


def left_out_traces(plain: FreeRuns, explained: FreeRuns, final: Attempt) -> tuple[Trace, ...]:
    """Training records; the run after the calibration is by the fit that left the record out, with what known causes
    explain in `explained`, and told as the record's own sensors would show it."""
    names = names_of_units(plain.units)
    return tuple(_trace(plain, explained, k, names[k], values) for k, values in enumerate(final.fitted.without))


def _trace(plain: FreeRuns, explained: FreeRuns, k: int, name: str, values: Mapping[str, float]) -> Trace:
    series, columns = plain.units[k].stretch.series, columns_of_states(plain)
    measured = plain.measured[k][:, : len(columns)]
    before = measured - blind_error(plain, k, {})
    after = measured - blind_error(explained, k, values)
    time = series.dt * (series.index + series.part)
    sides = [dict(zip(columns, part.T, strict=True)) for part in (measured, before, after)]
    return Trace(name, "train", time, series.observe(series.inputs[:, 0]), *sides)


def blind_error(runs: FreeRuns, k: int, values: Mapping[str, float]) -> np.ndarray:
    """Errors (N, S) of the states of a unit at values of the numbers, without own effects; 0 where nothing is
    measured."""
    error = runs.errors([Lane(k, values, runs.no_own[k])])[0][: len(runs.symbols), 0]
    return error.T
