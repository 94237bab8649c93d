"""Figures that show themselves: matplotlib figures, not attached to pyplot."""

from __future__ import annotations

import io
from base64 import b64encode
from collections.abc import Callable
from html import escape

from matplotlib import rcParams
from matplotlib.backend_bases import RendererBase
from matplotlib.figure import Figure
from matplotlib.text import Text

from .errors import BadInput

DOTS_PER_INCH = 100
DARK = (
    '<style>body:is([data-jp-theme-light="false"], .vscode-dark, .vscode-high-contrast) img.helmbench, '
    'html[theme="dark"] img.helmbench { filter: invert(.9) hue-rotate(180deg); }</style>'
)
"""Turns the light of pictures round in the dark themes of JupyterLab, Visual Studio Code and Colab."""


class PlainFigure(Figure):
    """A figure in which a dollar sign in a name is no formula."""

    def draw(self, renderer: RendererBase) -> None:
        axes = [axis for ax in self.axes for axis in (ax.xaxis, ax.yaxis)]
        powers = {label for axis in axes if axis.get_scale() == "log" for label in axis.get_ticklabels(which="both")}
        for text in self.findobj(Text) if rcParams["text.parse_math"] else powers:
            if isinstance(text, Text):
                text.set_parse_math(text in powers)
        super().draw(renderer)


class ShownFigure(PlainFigure):
    """A figure that a notebook draws, also without pyplot.

    Parameters
    ----------
    width, height : inches.
    """

    def __init__(self, width: float, height: float) -> None:
        super().__init__(figsize=(width, height), layout="constrained", facecolor="white")

    def _repr_png_(self) -> bytes:
        buffer = io.BytesIO()
        self.savefig(buffer, format="png", dpi=DOTS_PER_INCH)
        return buffer.getvalue()

    def _repr_html_(self) -> str:
        return picture(lambda: self, "figure")


def picture(draw: Callable[[], Figure], title: str) -> str:
    """A figure as an HTML image, for a notebook; empty where there is nothing to draw (BadInput).

    title : what is read to those who do not see it.
    """
    try:
        figure = draw()
    except BadInput:
        return ""
    assert isinstance(figure, ShownFigure)
    data = b64encode(figure._repr_png_()).decode()
    shown = f'class="helmbench" alt="{escape(title)}" style="max-width: 100%"'
    return f'{DARK}<img {shown} src="data:image/png;base64,{data}"/>'
