"""`helmbench reproduce [PAPER] [--table N]`."""

from __future__ import annotations

from typing import Any

import click

from ._from_api import ApiCommand
from ._shared import FAILED, FILE, OK, Printer, WholeRange, echo, output_options

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
def reproduce(paper: str | None, printer: Printer, **asked: Any) -> int:
    """Compute the tables of the five papers again.

    Tables and claims are compared with the printed ones; PAPER: 003 for one paper.
    """
    import helmbench

    found = helmbench.reproduce(paper, **asked, progress=printer.progress)
    for failure in found.failures:
        echo(f"failed: {failure}", err=True)
    told = [f"{row['paper']} {row['item']}, {row['quantity']}: {row['verdict']}. {row['reason']}" for row in found.rows]
    told += [f"paper {paper}: {counts}" for paper, counts in found.counts.items()]
    printer.show(lambda: found.rows, lambda: "\n".join(told))
    return FAILED if found.failures else OK
