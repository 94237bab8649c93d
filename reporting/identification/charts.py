"""Charts of residuals: correlation coefficients by lag inside their 99 % band."""

from __future__ import annotations

from functools import partial
from typing import TYPE_CHECKING

from ...datasets.display import shown_name
from ..page import Drawing
from ..plots import COLOURS, SOFT, svg
from ..runs import MARGINS, WIDTH

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from ...estimation.estimates.assessment import Assessment
    from ...estimation.estimates.correlation import Correlation

HEIGHT = 2.6
SIDES = {"training": COLOURS[0], "held out": COLOURS[1]}
"""Records -> colour of their coefficients."""


def residual_drawings(assessment: Assessment) -> list[Drawing]:
    """Of every channel the correlation of its residuals in time, and with the rudder."""
    sides = {"training": assessment.train_residuals, "held out": assessment.held_out_residuals}
    channels = dict.fromkeys(one.channel for own in sides.values() for one in own)
    out = []
    for channel in channels:
        own = {side: one for side, group in sides.items() for one in group if one.channel == channel}
        in_time = {side: one.in_time for side, one in own.items()}
        with_rudder = {side: one.with_rudder for side, one in own.items()}
        for other, coefficients in (("itself", in_time), ("the rudder", with_rudder)):
            caption = f"{shown_name(channel)}: residual with {other}, so long before"
            file = f"{channel}-{other.rpartition(' ')[2]}"
            out.append(Drawing(file, caption, partial(correlation_chart, coefficients)))
    return out


def correlation_chart(found: dict[str, Correlation]) -> str:
    """An SVG file of coefficients over the lag in s, beside each other, each in its band."""

    def draw(figure) -> None:
        axes: Axes = figure.subplots()
        for place, (side, one) in enumerate(found.items()):
            step = one.lag_s[1] - one.lag_s[0] if one.lag_s.size > 1 else 1.0
            at = one.lag_s + 0.25 * step * place
            axes.vlines(at, 0.0, one.values, color=SIDES[side], linewidth=1.2, label=side)
            axes.plot(at, one.values, "o", color=SIDES[side], markersize=2.5)
            for edge in (-one.band, one.band):
                axes.axhline(edge, color=SIDES[side], linewidth=0.8, linestyle=(0, (4, 2)))
        axes.axhline(0.0, color=SOFT, linewidth=0.7)
        axes.set(xlabel="lag, s", ylabel="correlation", ylim=_limits(found))
        axes.legend(loc="lower right", bbox_to_anchor=(1.0, 0.97), ncols=len(found))

    return svg(draw, (WIDTH, HEIGHT), {**MARGINS, "bottom": 0.17, "top": 0.92})


def _limits(found: dict[str, Correlation]) -> tuple[float, float]:
    largest = max(max(one.band, float(abs(one.values).max())) for one in found.values())
    edge = min(1.15 * largest, 1.05)
    return -edge, edge
