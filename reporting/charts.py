"""Charts of suites: rates with their intervals."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from .plots import chart, legend_beside

SIZE = (6.4, 2.9)


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
