"""Charts of the leaderboard: median errors of the best methods over the levels of noise and sampling."""

from __future__ import annotations

from collections.abc import Sequence

from ..charts import by_level
from ..plots import COLOURS, SOFT
from .standings import Leaderboard
from .tables import CRITERIA, FACTORS

DRAWN = 8
"""Methods in a chart: the best by mean rank."""


def charts(board: Leaderboard) -> list[tuple[str, str]]:
    """Pairs of title and SVG."""
    found = []
    for factor in [factor for factor in ("noise", "thinning", "length") if factor in board.by]:
        frame = board.by[factor]
        levels = list(dict.fromkeys(frame["group"]))
        drawn = [method for method in board.overall["method"] if method in set(frame["method"])][:DRAWN]
        for column, name in CRITERIA.items():
            values = frame.pivot(index="method", columns="group", values=column)
            series = {method: [float(value) for value in values.loc[method, levels]] for method in drawn}
            title = f"{name} by {FACTORS[factor]}" + (f", best {DRAWN} methods" if len(values) > DRAWN else "")
            found.append((title, by_level(series, _short(levels), title)))
    return [(title, svg) for title, svg in found if svg]


def _short(levels: Sequence[str]) -> list[str]:
    """Levels without what the first and others have before a comma."""
    head = levels[0].partition(",")[0] + ","
    return [level.removeprefix(head) for level in levels]


def standings_figure(board: Leaderboard):
    """Median prediction errors of all methods with their intervals, best first, on a logarithmic axis."""
    from matplotlib.figure import Figure

    rows = board.overall
    places = range(len(rows))
    figure = Figure(figsize=(7.5, 1.2 + 0.28 * len(rows)), layout="constrained")
    axes = figure.subplots()
    axes.hlines(places, rows["nrmse_low"], rows["nrmse_high"], color=SOFT, linewidth=1.0)
    axes.plot(rows["nrmse"], places, "o", color=COLOURS[0])
    axes.set_yticks(places, list(rows["method"]))
    axes.set(xscale="log", ylim=(len(rows) - 0.5, -0.5), xlabel=CRITERIA["nrmse"])
    axes.grid(True, linewidth=0.3)
    return figure
