"""`helmbench merge SOURCE TARGET`."""

from __future__ import annotations

import sys
from pathlib import Path

import click

from ._shared import FILE, WholeRange, confirmed, echo, output_options, print_json


@click.command()
@click.argument("source", metavar="SOURCE", type=FILE)
@click.argument("target", metavar="TARGET", type=FILE)
@click.option("--sample", type=WholeRange(min=0), default=5, show_default=True, help="Runs that are computed again.")
@click.option("--seed", type=WholeRange(min=0), default=0, show_default=True, help="Seed that draws the sample.")
@click.option("--trust", is_flag=True, help="Run code that the directories name.")
@output_options
def merge(source: Path, target: Path, sample: int, seed: int, trust: bool, as_json: bool, quiet: bool) -> None:
    """Check results from elsewhere and add them to the results in TARGET."""
    from .. import merge_results

    asks = confirmed if sys.stdin.isatty() and sys.stderr.isatty() else False
    found = merge_results(source, target, sample=sample, seed=seed, trust=trust or asks)
    if as_json:
        print_json(vars(found))
    elif not quiet:
        known = f"{found.known} were there already, {found.recomputed} were computed again and agree"
        echo(f"{found.added} runs added; {known}; next: helmbench report {target}")
