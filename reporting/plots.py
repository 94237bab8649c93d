"""Plots as SVG by matplotlib: one style, equal bytes every time, no state of pyplot."""

from __future__ import annotations

import io
import re
from collections.abc import Callable, Mapping
from html import escape
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

COLOURS = ("#1b6ca8", "#d1495b", "#2e8b57", "#b8860b", "#6a4c93", "#3d5a6c", "#c2652a", "#008b8b")
INK, SOFT, GRID = "#1d2733", "#5b6b7b", "#e4e4e4"
SIZE = (7.5, 4.2)
"""Width and height in inches of a figure that sets no other."""
STYLE: dict[str, Any] = {
    "svg.hashsalt": "helmbench",
    "svg.fonttype": "none",
    "font.family": "sans-serif",
    "font.sans-serif": ["DejaVu Sans"],
    "font.size": 9.0,
    "axes.grid": True,
    "grid.color": GRID,
    "grid.linewidth": 0.6,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "legend.frameon": False,
    "lines.linewidth": 1.2,
    "path.simplify_threshold": 0.3,
    "figure.facecolor": "white",
    "text.parse_math": False,
}
NO_METADATA = dict.fromkeys(("Date", "Creator", "Format", "Type"))


def svg(
    draw: Callable[[Figure], object], size: tuple[float, float] = SIZE, margins: Mapping[str, float] | None = None
) -> str:
    """An SVG file with what `draw` adds to an empty figure of (width, height) inches.

    margins : those of `Figure.subplots_adjust`; None fits them to the texts.
    """

    def make() -> Figure:
        from ..models.figure import PlainFigure

        figure = PlainFigure(figsize=size, layout="constrained" if margins is None else None)
        if margins is not None:
            figure.subplots_adjust(**margins)
        draw(figure)
        return figure

    return as_svg(make)


def as_svg(make: Callable[[], Figure]) -> str:
    """The figure that `make` draws in the style of all figures, in the place of the user's, as an SVG file."""
    import matplotlib
    from matplotlib.rcsetup import cycler

    style: dict[Any, Any] = {**matplotlib.rcParamsDefault, **STYLE, "axes.prop_cycle": cycler(color=COLOURS)}
    buffer = io.BytesIO()
    with matplotlib.rc_context(style):
        make().savefig(buffer, format="svg", metadata=NO_METADATA)
    lines = buffer.getvalue().decode().splitlines()
    return "\n".join(line.rstrip() for line in lines) + "\n"


def embedded(text: str, title: str) -> str:
    """The drawing of an SVG file, to be put into an HTML page: without prologue and without ids of groups."""
    body = re.sub(r' id="[a-zA-Z0-9]+_\d+"', "", text[text.index("<svg") :])
    return body.replace("<svg ", f'<svg role="img" aria-label="{escape(title)}" ', 1)


def chart(
    draw: Callable[[Figure], object],
    size: tuple[float, float],
    title: str,
    margins: Mapping[str, float] | None = None,
) -> str:
    """`svg` and `embedded` in one."""
    return embedded(svg(draw, size, margins), title)


def legend_beside(axes: Axes) -> None:
    """The legend to the right of the axes."""
    axes.legend(loc="upper left", bbox_to_anchor=(1.0, 1.0), borderaxespad=0.2)
