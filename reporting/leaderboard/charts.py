"""Figure of the standings."""

from __future__ import annotations

import math

from ..plots import COLOURS, SOFT
from .standings import Frame
from .tables import CRITERIA


def standings_figure(overall: Frame):
    """Median prediction errors of all methods with their intervals, best first, on a logarithmic axis."""
    from ...models.figure import ShownFigure

    places = range(len(overall))
    figure = ShownFigure(7.5, 1.2 + 0.28 * len(overall))
    axes = figure.subplots()
    axes.hlines(places, overall["nrmse_low"], overall["nrmse_high"], color=SOFT, linewidth=1.0)
    axes.plot(overall["nrmse"], places, "o", color=COLOURS[0])
    axes.set_yticks(places, list(overall["method"]))
    axes.set(xscale="log", ylim=(len(overall) - 0.5, -0.5), xlabel=CRITERIA["nrmse"])
    axes.grid(True, linewidth=0.3)
    for place, error in zip(places, overall["nrmse"], strict=True):
        if error == math.inf:
            across = axes.get_yaxis_transform()
            axes.text(0.98, place, "median: infinite", color=SOFT, ha="right", va="center", transform=across)
    return figure
