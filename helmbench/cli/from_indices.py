"""`helmbench from-indices SHIP.yaml -o model.json`."""

from __future__ import annotations

from pathlib import Path

import click

from ._shared import FAILED, FILE, OK, Printer, check_file, complain, force_option, output_options


@click.command("from-indices")
@click.argument("indices", metavar="SHIP.yaml", type=FILE)
@click.option("-o", "--output", type=FILE, help="model.json to write.")
@force_option
@output_options
def from_indices(indices: Path, output: Path | None, force: bool, printer: Printer) -> int:
    """Make a model from a wheelhouse poster or sea trial.

    SHIP.yaml holds length, approach speed, and indices of turning circles and zigzags (docs/how-to/from-indices.md).
    Prints every parameter with its interval, or that it is not determined, and the indices given and of the model.
    """
    import helmbench

    if output is not None:
        check_file(output, force)
    try:
        found = helmbench.model_from_indices(indices)
    except helmbench.FitFailed as reason:
        return complain(f"{indices}: {reason}", FAILED)
    if output is not None:
        found.save(output)
    files = [output] if output is not None else []
    printer.show(lambda: found.to_json() | {"output": str(output) if files else None}, found.summary, files)
    return OK
