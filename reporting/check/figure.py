"""The figure of a check: sizes of findings with their intervals."""

from __future__ import annotations

from typing import TYPE_CHECKING

from ...models.errors import BadInput
from ..diagnosis.words import cause
from ..plots import COLOURS, SOFT

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from ...checks.result import CheckResult

ALL = "all records"


def figure_of(found: CheckResult) -> Figure:
    """A panel a size of a finding: its value over all records and in each, with the 90 % intervals; BadInput where no
    finding has a size."""
    from ...models.figure import ShownFigure

    panels = [
        (one.cause, name, [size for size in one.sizes if size.parameter == name])
        for one in found.findings
        for name in dict.fromkeys(size.parameter for size in one.sizes)
    ]
    if not panels:
        raise BadInput("no finding of the check has a size to draw", hint="`findings` holds what was found")
    heights = [0.5 + len(sizes) for _, _, sizes in panels]
    figure = ShownFigure(7.5, 0.6 * len(panels) + 0.28 * sum(heights))
    axes = figure.subplots(len(panels), 1, squeeze=False, height_ratios=heights)[:, 0]
    for panel, (name, parameter, sizes) in zip(axes, panels, strict=True):
        for place, size in enumerate(sizes):
            colour = COLOURS[0] if size.record is None else SOFT
            panel.hlines(place, size.low, size.high, color=colour)
            panel.plot(size.value, place, "o", color=colour, markersize=4)
        panel.axvline(0.0, color=SOFT, linewidth=0.7)
        panel.set_yticks(range(len(sizes)), [size.record or ALL for size in sizes])
        panel.set(ylim=(len(sizes) - 0.5, -0.5), xlabel=f"{cause(name)}: {parameter}, {sizes[0].unit}")
    return figure
