"""Traces: a thinned free run along a held-out record, one a method and problem, stored with its run in the journal.

`"trace": {"record", "time_s", "channels": {name: {"measured", "predicted"}}, "log": {...}}`, in the units of the
channel's name; null is a gap or a value that is not finite.  `log` is that of a recursion, the published parameters
against time: `{"time_s", "values": {parameter: [...]}}`; other methods have none.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from ..datasets.record import Record
from ..estimation.estimates.estimate import Estimate
from ..estimation.judgement.convergence import parameter_paths
from ..estimation.run.run import run_along
from .journal import RUNS, read_runs

POINTS, LOGGED, DIGITS = 80, 40, 5
"""Most samples of a trace and of a recursion's log, and the significant digits of their values."""
LARGEST = 1e300


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


def _is_traced(run: Mapping[str, Any]) -> bool:
    """Whether a run has a trace that can be drawn: at each of its times a number, or a gap."""
    try:
        row, trace = run["row"], run["trace"]
        curves = [curve[side] for curve in trace["channels"].values() for side in ("measured", "predicted")]
        log: Any = trace.get("log") or {"time_s": [], "values": {}}
        groups = [trace["time_s"], *curves], [log["time_s"], *log["values"].values()]
        whole = all(isinstance(one, list) and len(one) == len(group[0]) for group in groups for one in group)
        values = [value for group in groups for one in group for value in one]
    except (AttributeError, KeyError, TypeError):
        return False
    known = whole and all(v is None or (type(v) in (int, float) and abs(v) < LARGEST) for v in values)
    plain = all(value is None or isinstance(value, str | int | float) for value in row.values())
    return known and plain and isinstance(trace.get("record"), str)


def _numbers(values: np.ndarray) -> list[float | None]:
    return [float(f"{value:.{DIGITS}g}") if np.isfinite(value) else None for value in values]
