"""Charts of residuals: correlation coefficients by lag inside their 99 % band."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from ...datasets.display import shown_name
from ..diagnosis.charts import MARGINS, WIDTH
from ..plots import COLOURS, SOFT, chart

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from ...estimation.judgement.assessment import Assessment
    from ...estimation.judgement.comparison import Comparison
    from ...estimation.judgement.correlation import Correlation

HEIGHT = 2.6
SIDES = {"training": COLOURS[0], "held out": COLOURS[1]}
"""Records -> colour of their coefficients."""


def residual_charts(found: Assessment) -> list[tuple[str, str]]:
    """Pairs of caption and drawing: of every channel the correlation in time, and with the rudder."""
    sides = {"training": found.train_residuals, "held out": found.held_out_residuals}
    channels = dict.fromkeys(one.channel for own in sides.values() for one in own)
    out = []
    for channel in channels:
        own = {side: one for side, group in sides.items() for one in group if one.channel == channel}
        name = shown_name(channel)
        in_time = {side: one.in_time for side, one in own.items()}
        with_rudder = {side: one.with_rudder for side, one in own.items()}
        out.append((f"{name}: residual with itself, so long before", correlation_chart(in_time, f"{name} in time")))
        title = f"{name} with the rudder"
        out.append((f"{name}: residual with the rudder, so long before", correlation_chart(with_rudder, title)))
    return out


def correlation_chart(found: dict[str, Correlation], title: str) -> str:
    """Coefficients over the lag in s, beside each other, each in its band."""

    def draw(figure) -> None:
        axes: Axes = figure.subplots()
        for place, (side, one) in enumerate(found.items()):
            step = one.lag_s[1] - one.lag_s[0] if one.lag_s.size > 1 else 1.0
            at = one.lag_s + 0.25 * step * place
            axes.vlines(at, 0.0, one.values, color=SIDES[side], linewidth=1.2)
            axes.plot(at, one.values, "o", color=SIDES[side], markersize=2.5)
            for edge in (-one.band, one.band):
                axes.axhline(edge, color=SIDES[side], linewidth=0.8, linestyle=(0, (4, 2)))
        axes.axhline(0.0, color=SOFT, linewidth=0.7)
        axes.set(xlabel="lag, s", ylabel="correlation", ylim=_limits(found))

    return chart(draw, (WIDTH, HEIGHT), title, {**MARGINS, "bottom": 0.17})


def _limits(found: dict[str, Correlation]) -> tuple[float, float]:
    largest = max(max(one.band, float(abs(one.values).max())) for one in found.values())
    edge = min(1.15 * largest, 1.05)
    return -edge, edge


def comparison_figure(found: Comparison) -> Figure:
    """The error of every candidate on each record that tests it, on a logarithmic axis; what failed is left out."""
    from ...models.figure import ShownFigure

    shown = [one for one in found.candidates if np.isfinite(one.error)]
    figure = ShownFigure(7.5, 1.2 + 0.32 * len(shown))
    axes = figure.subplots()
    for place, one in enumerate(shown):
        colour = COLOURS[0] if one is found.chosen else SOFT
        axes.plot(one.errors, [place] * len(one.errors), "|", color=colour, markersize=9)
        axes.plot(one.error, place, "o", color=colour)
    axes.set_yticks(range(len(shown)), [f"{one.model.id} by {one.method}" for one in shown])
    axes.set(xscale="log", ylim=(len(shown) - 0.5, -0.5), xlabel=f"error of free runs, {found.basis}")
    axes.grid(True, linewidth=0.3)
    return figure
