"""Stored traces: a thinned free run along a held-out record, one a method and problem, in `traces.jsonl`.

Each line holds the key columns of its run and the trace:
`{"row": {...}, "trace": {"record", "time_s", "channels": {name: {"measured", "predicted"}}}}`,
in the units of the channel's name; null is a gap or a value that is not finite.
"""

from __future__ import annotations

import json
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from ..models.data_file import json_of
from ..models.errors import BadInput

if TYPE_CHECKING:
    from ..datasets.record import Record
    from ..estimation.estimate import Estimate

TRACES = "traces.jsonl"
POINTS, DIGITS = 80, 5
"""Most samples of a trace, and the significant digits of its values."""


def free_run_trace(estimate: Estimate, record: Record) -> dict[str, Any]:
    """The trace of an estimate along a record of N samples, thinned to at most `POINTS`."""
    from ..estimation.prediction import predict

    kept = np.unique(np.linspace(0, record.n - 1, min(record.n, POINTS)).round().astype(int))
    channels = {
        found.channel: {"measured": _numbers(found.observed[kept]), "predicted": _numbers(found.free[kept])}
        for found in predict(estimate.model, record, estimate.predictor)
    }
    return {"record": record.name, "time_s": _numbers(record.time_s[kept]), "channels": channels}


def trace_line(row: Mapping[str, Any], keys: tuple[str, ...], trace: Mapping[str, Any]) -> bytes:
    """The line of a run's trace, with its end."""
    text = json.dumps({"row": {key: row[key] for key in keys}, "trace": trace}, allow_nan=False, ensure_ascii=False)
    return text.encode() + b"\n"


def read_traces(directory: str | Path) -> list[dict[str, Any]]:
    """The stored traces of a run directory; empty where there are none, damaged lines are passed over."""
    path = Path(directory) / TRACES
    lines = path.read_bytes().split(b"\n") if path.exists() else []
    found = [_trace(line, path, number) for number, line in enumerate(lines, start=1) if line.strip()]
    return [entry for entry in found if entry is not None]


def traces_by_row(directory: str | Path) -> Callable[[Mapping[str, Any], tuple[str, ...]], dict[str, Any] | None]:
    """The stored traces as a function of a run's row and the names of its key columns; None where there is none."""
    found = {json.dumps(entry["row"], sort_keys=True): entry["trace"] for entry in read_traces(directory)}
    return lambda row, keys: found.get(json.dumps({key: row[key] for key in keys}, sort_keys=True))


def _trace(line: bytes, path: Path, number: int) -> dict[str, Any] | None:
    try:
        entry = json_of(line, path, number)
    except BadInput:
        return None
    return entry if isinstance(entry, dict) and {"row", "trace"} <= entry.keys() else None


def _numbers(values: np.ndarray) -> list[float | None]:
    return [float(f"{value:.{DIGITS}g}") if np.isfinite(value) else None for value in values]
