"""The charts of one record of a diagnosis: rudder, every channel with its error, track."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from ..numbers import DEG, number
from . import words
from .charts import AFTER, BEFORE, MEASURED, Curve, channel_chart, rudder_chart, track_chart
from .errors import extent, residual, rms

if TYPE_CHECKING:
    from ...diagnosis.trace import Trace

CHANNELS = ("yaw_rate_rad_s", "heading_rad", "surge_m_s", "sway_m_s")
"""Channels with a chart each, in this order."""
DASHED = (0, (5, 3))


@dataclass(frozen=True)
class Panel:
    """One record: its name, pairs of caption and SVG, and its errors as a line of text."""

    record: str
    charts: tuple[tuple[str, str], ...]
    errors: str


def panel(trace: Trace, after: bool) -> Panel:
    """The charts of a record, with the extended model's run if `after`."""
    return Panel(trace.record, tuple((caption, svg) for caption, svg in _charts(trace, after) if svg),
                 error_line(trace, after))  # fmt: skip


def error_line(trace: Trace, after: bool) -> str:
    """Root mean square errors of a record's free runs, in one line."""
    texts = []
    for name in [c for c in (*CHANNELS, "north_m", "east_m") if c in trace.measured and c in trace.before]:
        word, unit, factor = words.channel(name)
        values = [number(factor * rms(residual(trace, name, run))) for run in ("before", "after")[: 1 + after]]
        texts.append(f"{word} {' → '.join(values)} {unit}")
    return ", ".join(texts)


def _charts(trace: Trace, after: bool) -> list[tuple[str, str]]:
    found = []
    for name in [c for c in CHANNELS if c in trace.measured]:
        word, unit, factor = words.channel(name)
        limit = 2.0 * factor * extent(trace.measured[name])
        overlay, errors = _overlay(trace, name, factor, after), _residuals(trace, name, factor, after)
        found.append((f"{word}; below, measured − simulated",
                      channel_chart(trace.time, overlay, errors, word, unit, limit)))  # fmt: skip
    if not found:
        return []
    rudder = ("rudder", rudder_chart(trace.time, DEG * trace.rudder))
    return [rudder, *found, ("track", track_chart(_tracks(trace, after), "track"))]


def _overlay(trace: Trace, name: str, factor: float, after: bool) -> list[Curve]:
    measured = Curve("measured", factor * _unwrapped(name, trace.measured[name]), MEASURED, width=1.3)
    shift = _turns(name, trace) * factor
    curves = [measured, Curve("before", factor * trace.before[name] + shift, BEFORE, DASHED)]
    return [*curves, Curve("after", factor * trace.after[name] + shift, AFTER)] if after else curves


def _residuals(trace: Trace, name: str, factor: float, after: bool) -> list[Curve]:
    curves = [Curve("before", factor * residual(trace, name, "before"), BEFORE)]
    return [*curves, Curve("after", factor * residual(trace, name, "after"), AFTER)] if after else curves


def _unwrapped(name: str, values: np.ndarray) -> np.ndarray:
    if name != "heading_rad":
        return values
    out, known = values.copy(), np.isfinite(values)
    out[known] = np.unwrap(values[known])
    return out


def _turns(name: str, trace: Trace) -> float:
    """Full turns, rad, by which the simulated heading is off the unwrapped measured one where both begin."""
    if name != "heading_rad":
        return 0.0
    gap = _unwrapped(name, trace.measured[name]) - trace.before[name]
    known = gap[np.isfinite(gap)]
    return float(2.0 * np.pi * np.round(known[0] / (2.0 * np.pi))) if known.size else 0.0


def _tracks(trace: Trace, after: bool) -> list[tuple[np.ndarray, np.ndarray, Curve]]:
    none = np.zeros(0)
    runs = [(trace.measured, Curve("measured", none, MEASURED, width=1.4))]
    runs.append((trace.before, Curve("before", none, BEFORE, DASHED)))
    runs += [(trace.after, Curve("after", none, AFTER))] if after else []
    if not {"north_m", "east_m"} <= trace.measured.keys():
        return []
    return [(run["north_m"], run["east_m"], curve) for run, curve in runs if {"north_m", "east_m"} <= run.keys()]
