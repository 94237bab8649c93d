"""`helmbench reproduce [PAPER] [--table N]`."""

from __future__ import annotations

from typing import Any

import click

from ._from_api import ApiCommand
from ._shared import FAILED, FILE, OK, WholeRange, echo, output_options, print_json, shows_progress

OPTIONS = {
    "table": WholeRange(min=1),
    "jobs": WholeRange(min=1),
    "seed": WholeRange(min=0),
    "resume": click.BOOL,
    "directory": {"type": FILE, "flag": "-o --output"},
}


@click.command(cls=ApiCommand, api="reproduce", options=OPTIONS)
@click.argument("paper", required=False, metavar="[PAPER]")
@output_options
def reproduce(paper: str | None, as_json: bool, quiet: bool, **asked: Any) -> int:
    """Compute the tables of the five papers again.

    Tables and claims are compared with the printed ones; PAPER: 003 for one paper.
    """
    import helmbench

    found = helmbench.reproduce(paper, **asked, progress=shows_progress(quiet or as_json))
    for failure in found.failures:
        echo(f"failed: {failure}", err=True)
    if as_json:
        print_json(found.rows)
    elif not quiet:
        for row in found.rows:
            echo(f"{row['paper']} {row['item']}, {row['quantity']}: {row['verdict']}. {row['reason']}")
        for paper, counts in found.counts.items():
            echo(f"paper {paper}: {counts}")
    return FAILED if found.failures else OK
