"""Charts of statistics: rates with their intervals, spectra, bars, a curve in its band."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence

import numpy as np

from .numbers import number
from .plots import SOFT, legend_beside, svg
from .runs import AFTER, WIDTH, DrawnCurve

SIZE = (6.4, 2.9)


def rate_curves(series: Mapping[str, Sequence[tuple[float, float, float, float]]]) -> str:
    """An SVG file of a line per name through (x, rate, low, high) with bars, x > 0 on a logarithmic axis, rates 0 .. 1.

    Bars of different names are moved apart a little.  Returns an empty text where there are no points.
    """
    if not any(series.values()):
        return ""

    def draw(figure) -> None:
        from matplotlib.ticker import PercentFormatter

        axes = figure.subplots()
        for place, (name, points) in enumerate(series.items()):
            x, rate, low, high = np.reshape(points, (-1, 4)).T
            ends = [rate - low, high - rate]
            axes.errorbar(x * 1.03**place, rate, ends, marker="o", markersize=4, elinewidth=0.8, capsize=2, label=name)
        axes.set(xscale="log", xlabel="non-centrality", ylim=(-0.03, 1.03))
        axes.yaxis.set_major_formatter(PercentFormatter(1.0))
        legend_beside(axes)

    return svg(draw, SIZE)


def spectra(frequency: np.ndarray, curves: Sequence[DrawnCurve], unit: str) -> str:
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
            found = (group.get(name, math.nan) for group in groups.values())
            sizes = [size if math.isfinite(size) else math.nan for size in found]
            places = np.arange(len(groups)) + height * (k - (len(names) - 1) / 2.0)
            drawn = axes.barh(places, sizes, height, color=colours[name], label=name)
            axes.bar_label(drawn, [number(size) for size in sizes], padding=3)
        axes.set_yticks(range(len(groups)), list(groups))
        axes.set(xlabel=label, ylim=(len(groups) - 0.5, -0.5), xlim=(0.0, 1.12 * max(values)))
        axes.grid(visible=False, axis="y")
        axes.legend(loc="lower left", bbox_to_anchor=(0.0, 1.0), ncols=len(names))

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
