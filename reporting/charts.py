"""Charts of statistics: rates with their intervals, a curve in its band."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from .plots import SOFT, legend_beside, svg
from .runs import AFTER, WIDTH

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
