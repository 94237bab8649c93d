"""Figure of the standings."""

from __future__ import annotations

from ..plots import COLOURS, SOFT
from .standings import Leaderboard
from .tables import CRITERIA


def standings_figure(board: Leaderboard):
    """Median prediction errors of all methods with their intervals, best first, on a logarithmic axis."""
    from ...models.figure import ShownFigure

    rows = board.overall
    places = range(len(rows))
    figure = ShownFigure(7.5, 1.2 + 0.28 * len(rows))
    axes = figure.subplots()
    axes.hlines(places, rows["nrmse_low"], rows["nrmse_high"], color=SOFT, linewidth=1.0)
    axes.plot(rows["nrmse"], places, "o", color=COLOURS[0])
    axes.set_yticks(places, list(rows["method"]))
    axes.set(xscale="log", ylim=(len(rows) - 0.5, -0.5), xlabel=CRITERIA["nrmse"])
    axes.grid(True, linewidth=0.3)
    return figure
