"""The standings of a run as an SVG file, as the README shows them: `make board-picture`."""

from __future__ import annotations

import io
import sys
from pathlib import Path

import matplotlib

from ...models.folders import make_folder, write_atomic
from ..plots import NO_METADATA, STYLE
from .board import Leaderboard, build
from .compact import read_compact
from .estimates import summarised


def drawn(board: Leaderboard) -> str:
    """`Leaderboard.plot` as the text of an SVG file, the same every time."""
    style: dict = {**matplotlib.rcParamsDefault, **STYLE}
    with matplotlib.rc_context(style):
        buffer = io.BytesIO()
        board.plot().savefig(buffer, format="svg", metadata=NO_METADATA)
    return "\n".join(line.rstrip() for line in buffer.getvalue().decode().splitlines()) + "\n"


def write_picture(results: Path, place: Path) -> None:
    """Draw the standings of stored results (a folder) into a file."""
    runs, parameters = read_compact(results)
    board = build(runs, summarised(parameters))
    make_folder(place.parent)
    write_atomic(place, drawn(board).encode())


if __name__ == "__main__":
    write_picture(Path(sys.argv[1]), Path(sys.argv[2]))
