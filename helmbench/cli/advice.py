"""`helmbench advice BOARD -o DIR`."""

from __future__ import annotations

from pathlib import Path

import click

from ._shared import FILE, METHOD, NUMBER, WholeRange, output_options, print_json, show_files, show_text, shows_progress


@click.command()
@click.argument("board", type=FILE)
@click.option("--situations", type=WholeRange(1, 100_000), default=60, show_default=True, help="How many are drawn.")
@click.option("--seed", type=WholeRange(min=0), default=0, show_default=True)
@click.option("--method", "methods", multiple=True, type=METHOD, help="Only these methods (repeatable); default: all.")
@click.option("--jobs", type=WholeRange(min=1), help="Worker processes, at most one a processor.")
@click.option("--timeout", type=NUMBER, help="Seconds until a run is ended and stored as failed.")
@click.option(
    "-o",
    "--output",
    default="advice-results",
    show_default=True,
    type=FILE,
    help="directory of the runs and the page; goes on where it stopped",
)
@output_options
def advice(
    board: Path,
    situations: int,
    seed: int,
    methods: tuple[str, ...],
    jobs: int | None,
    timeout: float | None,
    output: Path,
    as_json: bool,
    quiet: bool,
) -> None:
    """Test a leaderboard's advice in fresh situations.

    All methods run; the regret is of what the board names.
    """
    from .. import check_advice

    hidden = quiet or as_json
    found = check_advice(
        board,
        directory=output,
        situations=situations,
        seed=seed,
        methods=methods,
        jobs=jobs,
        timeout_s=timeout,
        progress=shows_progress(hidden),
    )
    if as_json:
        print_json(found.to_json())
    elif not quiet:
        show_text(found.summary())
        show_files(found.paths)
