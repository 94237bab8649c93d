"""Charts of suites: errors over the levels of a condition, rates with their intervals."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence

from .plots import chart, legend_beside, ticks

SIZE = (6.4, 2.9)


def by_level(series: Mapping[str, Sequence[float | None]], levels: Sequence[str], title: str) -> str:
    """A line per name over ordered levels on a logarithmic axis; points that are not positive and finite are left out.

    Returns an empty text where fewer than two levels or no points are given.
    """
    lines = {name: [_drawable(value) for value in line] for name, line in series.items()}
    lines = {name: line for name, line in lines.items() if not all(map(math.isnan, line))}
    if len(levels) < 2 or not lines:
        return ""

    def draw(figure) -> None:
        axes = figure.subplots()
        for name, line in lines.items():
            axes.semilogy(range(len(levels)), line, marker="o", markersize=4, label=name)
        ticks(axes, range(len(levels)), levels)
        axes.set_xlim(-0.3, len(levels) - 0.7)
        legend_beside(axes)

    return chart(draw, SIZE, title)


def rate_curves(series: Mapping[str, Sequence[tuple[float, float, float, float]]], title: str) -> str:
    """A line per name through (x, rate, low, high) with bars, x > 0 on a logarithmic axis, rates 0 .. 1.

    Bars of different names are moved apart a little.  Returns an empty text where there are no points.
    """
    if not any(series.values()):
        return ""

    def draw(figure) -> None:
        from matplotlib.ticker import PercentFormatter

        axes = figure.subplots()
        for place, (name, points) in enumerate(series.items()):
            x = [point[0] * 1.03**place for point in points]
            rate = [point[1] for point in points]
            bars = [[r - point[2] for r, point in zip(rate, points, strict=True)],
                    [point[3] - r for r, point in zip(rate, points, strict=True)]]  # fmt: skip
            axes.errorbar(x, rate, bars, marker="o", markersize=4, elinewidth=0.8, capsize=2, label=name)
        axes.set(xscale="log", xlabel="non-centrality", ylim=(-0.03, 1.03))
        axes.yaxis.set_major_formatter(PercentFormatter(1.0))
        legend_beside(axes)

    return chart(draw, SIZE, title)


def _drawable(value: float | None) -> float:
    """The value if a logarithmic axis can show it, else nan."""
    return value if value is not None and math.isfinite(value) and value > 0.0 else math.nan
