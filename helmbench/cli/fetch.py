"""`helmbench fetch DATASET`."""

from __future__ import annotations

import click

from ._shared import echo, output_options, print_json, shows_progress


@click.command()
@click.argument("dataset")
@output_options
def fetch(dataset: str, as_json: bool, quiet: bool) -> None:
    """Download a measured set into HELMBENCH_DATA, SHA-256 checked."""
    import helmbench

    paths = helmbench.fetch(dataset, progress=shows_progress(quiet or as_json))
    if as_json:
        print_json({"dataset": dataset, "files": [str(path) for path in paths]})
    elif not quiet:
        echo(f"{dataset}: {len(paths)} files in {paths[0].parent}")
