"""`helmbench fetch DATASET`."""

from __future__ import annotations

import click

from ._shared import Printer, output_options


@click.command()
@click.argument("dataset")
@output_options
def fetch(dataset: str, printer: Printer) -> None:
    """Download a measured set into HELMBENCH_DATA, SHA-256 checked."""
    import helmbench

    paths = helmbench.fetch(dataset, progress=printer.progress)
    told = f"{dataset}: {len(paths)} files in {paths[0].parent}"
    printer.show(lambda: {"dataset": dataset, "files": [str(path) for path in paths]}, lambda: told)
