"""`helmbench reproduce [PAPER] [--table N]`."""

from __future__ import annotations

from pathlib import Path

import click

from ._shared import FAILED, FILE, OK, WholeRange, echo, output_options, print_json, shows_progress


@click.command()
@click.argument("paper", required=False, metavar="[PAPER]")
@click.option("--table", type=WholeRange(min=1), help="Only the claims of this table.")
@click.option("--jobs", type=WholeRange(min=1), help="Worker processes; default and most: one for each processor.")
@click.option("--seed", type=WholeRange(min=0), default=0, help="Other random numbers in every computation.")
@click.option("--resume", is_flag=True, help="Continue a computation that was interrupted.")
@click.option("-o", "--output", type=FILE, help="Keep runs, results and pages in this directory.")
@output_options
def reproduce(
    paper: str | None,
    table: int | None,
    jobs: int | None,
    seed: int,
    resume: bool,
    output: Path | None,
    as_json: bool,
    quiet: bool,
) -> int:
    """Compute the tables of the five papers again.

    Tables and claims are compared with the printed ones; PAPER: 003 for one paper.
    """
    import helmbench

    show = shows_progress(quiet or as_json)
    found = helmbench.reproduce(paper, table, directory=output, jobs=jobs, resume=resume, seed=seed, progress=show)
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
