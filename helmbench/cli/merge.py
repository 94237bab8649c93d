"""`helmbench merge SOURCE TARGET`."""

from __future__ import annotations

import sys
from pathlib import Path

import click

from ._shared import FILE, WholeRange, confirmed, echo, output_options, print_json


@click.command()
@click.argument("source", metavar="SOURCE", type=FILE)
@click.argument("target", metavar="TARGET", type=FILE)
@click.option("--sample", type=WholeRange(min=0), help="Runs that are computed again.  [default: 5 %, at least 30]")
@click.option("--seed", type=WholeRange(min=0), help="Seed that draws the sample.  [default: a new one]")
@click.option("--trust", is_flag=True, help="Run code that the directories name.")
@output_options
def merge(
    source: Path, target: Path, sample: int | None, seed: int | None, trust: bool, as_json: bool, quiet: bool
) -> None:
    """Check results from elsewhere and add them to TARGET."""
    from .. import merge_results

    asks = confirmed if sys.stdin.isatty() and sys.stderr.isatty() else False
    found = merge_results(source, target, sample=sample, seed=seed, trust=trust or asks)
    if as_json:
        print_json(vars(found))
    elif not quiet:
        known = f"{found.known} were there already, {found.recomputed} were computed again and agree"
        echo(f"{found.added} runs added; {known}; sample of seed {found.seed} (--seed {found.seed} draws it again)")
        for told in found.not_computable:
            echo(f"not verified: {told}")
        if found.forged and found.recomputed < found.added:
            echo(f"had {found.forged} of them been forged, the sample would have held one with a probability of 95 %")
        echo(f"next: helmbench report {target}")
