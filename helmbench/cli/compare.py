"""`helmbench compare A B`."""

from __future__ import annotations

from pathlib import Path

import click

from ._shared import FILE, output_options, print_json, show_text


@click.command()
@click.argument("first", metavar="A", type=FILE)
@click.argument("second", metavar="B", type=FILE)
@output_options
def compare(first: Path, second: Path, as_json: bool, quiet: bool) -> None:
    """Say what changed between two result directories.

    Runs are paired; every change has an interval.
    """
    from .. import compare_results

    found = compare_results(first, second)
    if as_json:
        print_json(found.to_json())
    elif not quiet:
        show_text(found.summary())
