"""Traces: a thinned free run along a held-out record, one a method and problem, stored with its run in the journal.

`"trace": {"record", "time_s", "channels": {name: {"measured", "predicted"}}, "log": {...}}`, in the units of the
channel's name; null is a gap or a value that is not finite.  `log` is that of a recursion, the published parameters
against time: `{"time_s", "values": {parameter: [...]}}`; other methods have none.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any, TypeVar

import numpy as np
from pydantic import BaseModel, ConfigDict, ValidationError, model_validator

from ..datasets.record import Record
from ..estimation.estimates.estimate import Estimate
from ..estimation.judgement.convergence import parameter_paths
from ..estimation.run.run import run_along
from .journal import RUNS, read_runs

Content = TypeVar("Content")
POINTS, LOGGED, DIGITS = 80, 40, 5
"""Most samples of a trace and of a recursion's log, and the significant digits of their values."""


class _Content(BaseModel):
    model_config = ConfigDict(strict=True)


class _Curve(_Content):
    measured: list[float | None]
    predicted: list[float | None]


class _Log(_Content):
    time_s: list[float | None]
    values: dict[str, list[float | None]]

    @model_validator(mode="after")
    def whole(self) -> _Log:
        """Refuses paths that are longer or shorter than their times."""
        return _whole(self, self.time_s, self.values.values())


class _Trace(_Content):
    """What a trace must hold to be drawn: a value, or a gap, at each of its times."""

    record: str
    time_s: list[float | None]
    channels: dict[str, _Curve]
    log: _Log | None = None

    @model_validator(mode="after")
    def whole(self) -> _Trace:
        """Refuses curves that are longer or shorter than their times."""
        curves = self.channels.values()
        return _whole(self, self.time_s, [side for curve in curves for side in (curve.measured, curve.predicted)])


def _whole(content: Content, time_s: Sequence[object], curves: Iterable[Sequence[object]]) -> Content:
    if any(len(values) != len(time_s) for values in curves):
        raise ValueError("needs a value at each time")
    return content


class _TracedRun(_Content):
    row: dict[str, str | int | float | bool | None]
    trace: _Trace


def free_run_trace(estimate: Estimate, record: Record) -> dict[str, Any]:
    """The trace of an estimate along a record of N samples, thinned to at most `POINTS`, with the recursion's log."""
    kept = _thinned(record.n, POINTS)
    run = run_along(estimate.model, record, estimate.predictor)
    channels = {
        name: {"measured": _numbers(run.measured.channels[name][kept]), "predicted": _numbers(values[kept])}
        for name, values in run.predicted.items()
    }
    trace = {"record": record.name, "time_s": _numbers(record.time_s[kept]), "channels": channels}
    return trace | ({} if (log := recursion_log(estimate)) is None else {"log": log})


def recursion_log(estimate: Estimate) -> dict[str, Any] | None:
    """The published parameters along the trajectory of a recursive method, thinned to `LOGGED` times; else None."""
    if estimate.trajectory is None or estimate.trajectory_time_s is None:
        return None
    kept = _thinned(len(estimate.trajectory), LOGGED)
    paths = parameter_paths(replace(estimate, trajectory=estimate.trajectory[kept]))
    values = {name: _numbers(path) for name, path in paths.items()}
    return {"time_s": _numbers(estimate.trajectory_time_s[kept]), "values": values}


def _thinned(count: int, most: int) -> np.ndarray:
    """Indices of at most `most` of `count` samples, the first and the last one included."""
    return np.unique(np.linspace(0, count - 1, min(count, most)).round().astype(int))


def read_traces(directory: str | Path) -> list[dict[str, Any]]:
    """The stored runs of a run directory that have a trace; those whose trace cannot be drawn are passed over."""
    return [run for run in read_runs(Path(directory) / RUNS) if _is_traced(run)]


def _is_traced(run: dict[str, Any]) -> bool:
    try:
        _TracedRun.model_validate(run)
    except ValidationError:
        return False
    return True


def _numbers(values: np.ndarray) -> list[float | None]:
    return [float(f"{value:.{DIGITS}g}") if np.isfinite(value) else None for value in values]
