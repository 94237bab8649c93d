"""Charts of a diagnosis: time series above their errors, tracks, spectra, bars."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from ..numbers import number
from ..plots import INK, SOFT, Sheet, svg

MEASURED, BEFORE, AFTER = INK, "#c8553d", "#1b6ca8"
WIDTH, HEIGHT = 6.4, 3.4
"""Inches."""

MARGINS = {"left": 0.11, "right": 0.965, "bottom": 0.13, "top": 0.97, "hspace": 0.08}
"""Fixed margins of the charts of a record: a page has dozens of them, and fitting margins is slow."""
RUDDER = Sheet(lambda figure: figure.subplots(), (WIDTH, HEIGHT), MARGINS)
TRACK = Sheet(lambda figure: figure.subplots(), (WIDTH, HEIGHT), MARGINS)
CHANNEL = Sheet(lambda figure: figure.subplots(2, 1, sharex=True, height_ratios=(2, 1)), (WIDTH, HEIGHT), MARGINS)


@dataclass(frozen=True)
class Curve:
    """One line: label, values (N,), colour, style and width in points."""

    label: str
    values: np.ndarray
    colour: str
    style: Any = "-"
    width: float = 1.0


def rudder_chart(time: np.ndarray, rudder: np.ndarray) -> str:
    """The rudder angle (N,) in degrees over time in s."""

    def draw(axes) -> None:
        axes.plot(time, rudder, color=SOFT, linewidth=1.0)
        axes.set(xlim=(time[0], time[-1]), ylabel="deg", xlabel="time, s")

    return RUDDER.chart(draw, "rudder")


def channel_chart(
    time: np.ndarray, overlay: Sequence[Curve], residual: Sequence[Curve], title: str, unit: str, limit: float
) -> str:
    """Measured and simulated values over time in s, and below them their differences.

    A simulation is cut off where it leaves the measured range by more than `limit`, a difference at +- `limit`.  Empty
    where nothing is finite.
    """
    if value_range([c.values for c in overlay]) is None:
        return ""

    def draw(axes) -> None:
        above, below = axes
        _lines(above, time, overlay)
        _lines(below, time, residual)
        below.axhline(0.0, color=SOFT, linewidth=0.7)
        above.set(ylim=value_range([c.values for c in overlay], limit), ylabel=unit, xlim=(time[0], time[-1]))
        below.set(ylim=error_range([c.values for c in residual], limit), ylabel=unit, xlabel="time, s")

    return CHANNEL.chart(draw, title)


def track_chart(curves: Sequence[tuple[np.ndarray, np.ndarray, Curve]], title: str) -> str:
    """Positions (north, east) in m to equal scales, north up; empty where nothing is finite."""
    known = [curve for curve in curves if np.isfinite(curve[0] + curve[1]).any()]
    if not known:
        return ""

    def draw(axes) -> None:
        for north, east, curve in known:
            x, y = _within(east, [e for _, e, _ in known]), _within(north, [n for n, _, _ in known])
            axes.plot(x, y, color=curve.colour, linestyle=curve.style, linewidth=curve.width)
        north, east, _ = known[0]
        first = int(np.argmax(np.isfinite(north + east)))
        axes.plot(east[first], north[first], "o", color=MEASURED, markersize=4)
        axes.set(xlabel="east, m", ylabel="north, m", aspect="equal", adjustable="datalim")

    return TRACK.chart(draw, title)


def spectra(frequency: np.ndarray, curves: Sequence[Curve], unit: str) -> str:
    """An SVG file of amplitudes over frequency in Hz on logarithmic axes; empty where nothing is positive."""
    values = np.concatenate([c.values for c in curves]) if curves else np.zeros(0)
    if not (np.isfinite(values) & (values > 0.0)).any() or frequency.size < 2:
        return ""

    def draw(figure) -> None:
        axes = figure.subplots()
        for curve in curves:
            axes.loglog(frequency, curve.values, color=curve.colour, linewidth=curve.width, label=curve.label)
        axes.set(xlabel="frequency, Hz", ylabel=unit)
        axes.legend()

    return svg(draw, (WIDTH, 2.6))


def bars(groups: Mapping[str, Mapping[str, float]], colours: Mapping[str, str], label: str) -> str:
    """An SVG file of horizontal bars: one group a line, one bar a name in it."""
    names = list(dict.fromkeys(name for group in groups.values() for name in group))
    values = [v for group in groups.values() for v in group.values() if math.isfinite(v)]
    if not values or max(values) <= 0.0:
        return ""
    height = 0.8 / len(names)

    def draw(figure) -> None:
        axes = figure.subplots()
        for k, name in enumerate(names):
            sizes = [group.get(name, math.nan) for group in groups.values()]
            places = np.arange(len(groups)) + height * (k - (len(names) - 1) / 2.0)
            drawn = axes.barh(places, sizes, height, color=colours[name], label=name)
            axes.bar_label(drawn, [number(size) for size in sizes], padding=3)
        axes.set_yticks(range(len(groups)), list(groups))
        axes.set(xlabel=label, ylim=(len(groups) - 0.5, -0.5), xlim=(0.0, 1.12 * max(values)))
        axes.grid(visible=False, axis="y")
        axes.legend()

    return svg(draw, (WIDTH, 0.9 + 0.2 * len(groups) * (len(names) + 1)))


def band(
    x: np.ndarray, y: Sequence[float], ends: tuple[Sequence[float], Sequence[float]], label: str, unit: str
) -> str:
    """An SVG file of a curve y (N,) over x (N,) in the band between its ends (N,)."""

    def draw(figure) -> None:
        axes = figure.subplots()
        axes.fill_between(x, *ends, color=AFTER, alpha=0.2, linewidth=0.0)
        axes.plot(x, y, color=AFTER, linewidth=1.5)
        axes.axhline(0.0, color=SOFT, linewidth=0.7)
        axes.set(xlabel=label, ylabel=unit, xlim=(x[0], x[-1]))

    return svg(draw, (WIDTH, 2.6))


def value_range(arrays: Sequence[np.ndarray], limit: float | None = None) -> tuple[float, float] | None:
    """Padded range of what is finite, at most `limit` (None: twice its range) beyond the first array; None where
    nothing is."""
    known = [a[np.isfinite(a)] for a in arrays]
    if not any(a.size for a in known):
        return None
    values, first = np.concatenate(known), known[0]
    if first.size and first.max() > first.min():
        reach = 2.0 * (first.max() - first.min()) if limit is None else limit
        values = np.clip(values, first.min() - reach, first.max() + reach)
    return _padded(float(values.min()), float(values.max()))


def error_range(arrays: Sequence[np.ndarray], limit: float) -> tuple[float, float]:
    """Padded range of what is finite between +- `limit`, zero within it."""
    values = np.append(np.concatenate([a[np.isfinite(a)] for a in arrays]), 0.0)
    values = np.clip(values, -limit, limit)
    return _padded(float(values.min()), float(values.max()))


def _within(values: np.ndarray, arrays: Sequence[np.ndarray]) -> np.ndarray:
    """The values with nan where they lie outside the range of what is drawn."""
    low, high = value_range(arrays) or (-math.inf, math.inf)
    return np.where((values >= low) & (values <= high), values, np.nan)


def _padded(low: float, high: float) -> tuple[float, float]:
    pad = 0.06 * (high - low) or max(abs(low), 1.0) * 0.1
    return low - pad, high + pad


def _lines(axes, time: np.ndarray, curves: Sequence[Curve]) -> None:
    for curve in curves:
        axes.plot(time, curve.values, color=curve.colour, linestyle=curve.style, linewidth=curve.width)
