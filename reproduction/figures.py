"""Figures of the pages: drawn by a paper's module on a matplotlib figure, as SVG with equal bytes every time."""

from __future__ import annotations

import hashlib
import io
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from ..bench.store import write_atomic
from ..reporting.plots import COLOURS
from .claims import Figure, Paper
from .study import StudyResult, module_of

if TYPE_CHECKING:
    from matplotlib.figure import Figure as Canvas

FOLDER = "figures"
SIZE = (7.5, 4.2)
"""Inches; a drawing may set another size on its figure."""
STYLE: dict[str, Any] = {
    "svg.hashsalt": "helmbench",
    "svg.fonttype": "none",
    "font.family": "sans-serif",
    "font.sans-serif": ["DejaVu Sans"],
    "font.size": 9.0,
    "axes.grid": True,
    "grid.color": "#e4e4e4",
    "grid.linewidth": 0.6,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "legend.frameon": False,
    "lines.linewidth": 1.2,
    "path.simplify_threshold": 1.0,
    "figure.facecolor": "white",
}


def file_of(paper: str, figure: Figure) -> str:
    """Path of a figure's file within the pages."""
    return f"{FOLDER}/{paper}-{figure.id}.svg"


def write(paper: Paper, figure: Figure, results: Sequence[StudyResult], directory: Path) -> str:
    """Draw a figure from its study's results, in order of their seeds; returns the SHA-256 of the file.

    The paper's module has `draw(results, figure)`, which adds axes to an empty matplotlib figure.
    """
    data = svg(getattr(module_of(paper.paper), figure.draw), results)
    path = directory / file_of(paper.paper, figure)
    path.parent.mkdir(parents=True, exist_ok=True)
    write_atomic(path, data)
    return hashlib.sha256(data).hexdigest()


def svg(draw: Callable[[Sequence[StudyResult], Canvas], object], results: Sequence[StudyResult]) -> bytes:
    """The drawing as SVG without date or random identifiers."""
    import matplotlib
    from matplotlib.figure import Figure as Canvas
    from matplotlib.rcsetup import cycler

    style: dict[Any, Any] = {**matplotlib.rcParamsDefault, **STYLE, "axes.prop_cycle": cycler(color=COLOURS)}
    with matplotlib.rc_context(style):
        canvas = Canvas(figsize=SIZE, layout="constrained")
        draw(results, canvas)
        buffer = io.BytesIO()
        canvas.savefig(buffer, format="svg", metadata={"Date": None, "Creator": None})
    lines = buffer.getvalue().decode().splitlines()
    return ("\n".join(line.rstrip() for line in lines) + "\n").encode()
