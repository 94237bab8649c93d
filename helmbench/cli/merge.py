"""`helmbench merge SOURCE TARGET`."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import Any

import click

from ._from_api import ApiCommand
from ._shared import FILE, Printer, WholeRange, confirmed, output_options

OPTIONS = {"sample": WholeRange(min=0), "seed": WholeRange(min=0)}


@click.command(cls=ApiCommand, api="merge_results", options=OPTIONS)
@click.argument("source", metavar="SOURCE", type=FILE)
@click.argument("target", metavar="TARGET", type=FILE)
@click.option("--trust", is_flag=True, help="Run code that the directories name.")
@output_options
def merge(source: Path, target: Path, trust: bool, printer: Printer, **asked: Any) -> None:
    """Check results from elsewhere and add them to TARGET."""
    from .. import merge_results

    asks = confirmed if sys.stdin.isatty() and sys.stderr.isatty() else False
    found = merge_results(source, target, **asked, trust=trust or asks)
    known = f"{found.known} were there already, {found.recomputed} were computed again and agree"
    told = [f"{found.added} runs added; {known}; sample of seed {found.seed} (--seed {found.seed} draws it again)"]
    told += [f"not verified: {why}" for why in found.not_computable]
    if found.forged and found.recomputed < found.added:
        told += [f"had {found.forged} of them been forged, the sample would have held one with a probability of 95 %"]
    printer.show(lambda: vars(found), lambda: "\n".join([*told, f"next: helmbench report {target}"]))
