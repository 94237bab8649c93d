"""`helmbench report DIR`."""

from __future__ import annotations

from pathlib import Path

import click

from ._shared import FILE, output_options, print_json, show_files, show_text


@click.command()
@click.argument("directory", metavar="DIR", type=FILE)
@click.option("--timing", type=FILE, help="Benchmark JSON to show; default: DIR/timing.json.")
@click.option("--csv", is_flag=True, help="Also write runs.csv and parameters.csv: a row a run, a row a parameter.")
@output_options
def report(directory: Path, timing: Path | None, csv: bool, as_json: bool, quiet: bool) -> None:
    """Write the report of stored results.

    Markdown, CSV and HTML; nothing is fitted again.
    """
    from .. import write_report

    written = write_report(directory, timing, csv=csv)
    if as_json:
        print_json(written.as_dict())
    elif not quiet:
        show_text(written.overview)
        show_files(written.paths)
