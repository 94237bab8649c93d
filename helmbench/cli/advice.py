"""`helmbench advice BOARD -o DIR`."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import click

from ._from_api import ApiCommand, several
from ._shared import FILE, METHOD, NUMBER, Printer, WholeRange, output_options

OPTIONS = {
    "situations": WholeRange(1, 100_000),
    "seed": WholeRange(min=0),
    "methods": several(METHOD, "--method"),
    "jobs": WholeRange(min=1),
    "timeout_s": NUMBER,
}


@click.command(cls=ApiCommand, api="check_advice", options=OPTIONS)
@click.argument("board", type=FILE)
@click.option(
    "-o",
    "--output",
    default="advice-results",
    show_default=True,
    type=FILE,
    help="directory of the runs and the page; goes on where it stopped",
)
@output_options
def advice(board: Path, output: Path, printer: Printer, **asked: Any) -> None:
    """Test a leaderboard's advice in fresh situations.

    All methods run; the regret is of what the board names.
    """
    from .. import check_advice

    found = check_advice(board, directory=output, **asked, progress=printer.progress)
    printer.show(found.to_json, found.summary, found.paths, markdown=True)
