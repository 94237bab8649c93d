"""`helmbench compare A B`."""

from __future__ import annotations

from pathlib import Path

import click

from ._shared import FILE, Printer, output_options


@click.command()
@click.argument("first", metavar="A", type=FILE)
@click.argument("second", metavar="B", type=FILE)
@output_options
def compare(first: Path, second: Path, printer: Printer) -> None:
    """Say what changed between two result directories.

    Runs are paired; every change has an interval.
    """
    from .. import compare_results

    found = compare_results(first, second)
    printer.show(found.to_json, found.summary, markdown=True)
