"""Figures of a diagnosis: errors by record, spectra of the errors, forces that remain."""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial
from typing import TYPE_CHECKING

import numpy as np

from ..charts import band, bars, spectra
from ..errors import banded, residual, rms
from ..page import Drawing
from ..runs import AFTER, BEFORE, CHANNELS, DrawnCurve
from . import words

if TYPE_CHECKING:
    from ...diagnosis.result import Diagnosis, RemainingForce, Trace

BANDS = 14
"""Frequency bands, equally wide on a logarithmic axis, into which a spectrum of errors is averaged."""
COLOURS = {"before": BEFORE, "after": AFTER}


def error_drawings(diagnosis: Diagnosis) -> list[Drawing]:
    """Errors by record, and a spectrum of the errors of each channel."""
    drawn = [Drawing("errors", "Root mean square errors of the free runs", lambda: error_bars(diagnosis))]
    for name in CHANNELS:
        caption = f"Spectrum of the {words.channel(name)[0]} errors"
        drawn.append(Drawing(f"spectrum-{name}", caption, partial(spectrum_figure, diagnosis, name)))
    return drawn


def force_drawings(diagnosis: Diagnosis) -> list[Drawing]:
    """A curve of each force that remains."""
    caption = "The force with its 90 % band, where the records hold data"
    return [
        Drawing(f"remaining-{place}", caption, partial(curve_chart, force))
        for place, force in enumerate(diagnosis.remaining, 1)
        if force.curve is not None
    ]


def error_bars(diagnosis: Diagnosis) -> str:
    """RMS error of the first channel that was measured by record, before and after."""
    name = next((c for c in CHANNELS if any(c in trace.measured for trace in diagnosis.traces)), None)
    if name is None:
        return ""
    word, unit, factor = words.channel(name)
    groups = {
        f"{trace.record} ({trace.role.replace('_', ' ')})": {
            run: factor * rms(residual(trace, name, run)) for run in _runs(diagnosis)
        }
        for trace in diagnosis.traces
        if name in trace.measured
    }
    return bars(groups, COLOURS, f"RMS error of the {word}, {unit}")


def spectrum_figure(diagnosis: Diagnosis, name: str) -> str:
    """Amplitude spectrum of a channel's errors on the held-out records (or all), before and after, in bands."""
    traces = [t for t in diagnosis.traces if name in t.measured]
    traces = [t for t in traces if t.role != "train"] or traces
    edges = _bands(traces) if traces else None
    if edges is None:
        return ""
    _, unit, factor = words.channel(name)
    curves = []
    for run in _runs(diagnosis):
        power = np.stack([banded(t.time, residual(t, name, run), edges) for t in traces])
        known = np.isfinite(power)
        mean = np.where(known, power, 0.0).sum(axis=0) / np.where(known.any(axis=0), known.sum(axis=0), np.nan)
        curves.append(DrawnCurve(run, factor * np.sqrt(mean), COLOURS[run], width=1.5))
    return spectra(np.sqrt(edges[:-1] * edges[1:]), curves, f"{unit} / √Hz")


def curve_chart(force: RemainingForce) -> str:
    """A force over the variable that it depends on with its 90 % band; empty where it has no curve."""
    curve = force.curve
    if curve is None:
        return ""
    unit, factor = ("deg", words.DEG) if curve.variable_unit == "rad" else (curve.variable_unit, 1.0)
    label = curve.variable + (f", {unit}" if unit != "1" else ", U/L")
    return band(factor * np.array(curve.values), curve.force, (curve.low, curve.high), label, curve.force_unit)


def _runs(diagnosis: Diagnosis) -> tuple[str, ...]:
    return ("before", "after")[: 1 + diagnosis.extends]


def _bands(traces: Sequence[Trace]) -> np.ndarray | None:
    longest = max(float(t.time[-1] - t.time[0]) for t in traces)
    step = max(float(np.median(np.diff(t.time))) for t in traces)
    low, high = 4.0 / longest, 0.5 / step
    return np.geomspace(low, high, BANDS + 1) if high > 2.0 * low else None
