"""`helmbench advice BOARD -o DIR`."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import click

from ._from_api import ApiCommand, several
from ._shared import FILE, METHOD, NUMBER, WholeRange, output_options, print_json, show_files, show_text, shows_progress

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
def advice(board: Path, output: Path, as_json: bool, quiet: bool, **asked: Any) -> None:
    """Test a leaderboard's advice in fresh situations.

    All methods run; the regret is of what the board names.
    """
    from .. import check_advice

    found = check_advice(board, directory=output, **asked, progress=shows_progress(quiet or as_json))
    if as_json:
        print_json(found.to_json())
    elif not quiet:
        show_text(found.summary())
        show_files(found.paths)
