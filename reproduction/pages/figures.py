"""Figures of the pages: drawn by a paper's module on a matplotlib figure, as SVG with equal bytes every time."""

from __future__ import annotations

import hashlib
from collections.abc import Sequence
from pathlib import Path

from ...models.folders import make_folder, write_atomic
from ...reporting.plots import svg
from ..claims.claim import Figure, Paper
from ..papers.study import StudyResult, drawing_of

FOLDER = "figures"


def file_of(paper: str, figure: Figure) -> str:
    """Path of a figure's file within the pages."""
    return f"{FOLDER}/{paper}-{figure.id}.svg"


def write(paper: Paper, figure: Figure, results: Sequence[StudyResult], directory: Path) -> str:
    """Draw a figure from its study's results, in order of their seeds; returns the SHA-256 of the file."""
    draw = drawing_of(paper.paper, figure.draw)
    data = svg(lambda canvas: draw(results, canvas)).encode()
    path = directory / file_of(paper.paper, figure)
    make_folder(path.parent, within=directory)
    write_atomic(path, data)
    return hashlib.sha256(data).hexdigest()
