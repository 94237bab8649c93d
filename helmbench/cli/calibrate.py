"""`helmbench calibrate --model M --train RECORD... --held-out RECORD... [-o DIR]`."""

from __future__ import annotations

from pathlib import Path

import click

from ._shared import (
    MODEL,
    TwoSets,
    check_folder,
    find_and_write,
    force_option,
    output_options,
    two_sets_options,
)


@click.command(cls=TwoSets)
@click.option("--model", required=True, type=MODEL, help="Vessel id or model.json, 3-DOF.")
@two_sets_options("Records.", "Records that are scored at the end.", "calibrate-results")
@force_option
@output_options
def calibrate(
    model: str,
    train: tuple[Path, ...],
    held_out: tuple[Path, ...],
    positive_rudder: str | None,
    output: Path,
    force: bool,
    as_json: bool,
    quiet: bool,
) -> int:
    """Say which numbers of a model are wrong, and by how much.

    Judged by free runs of records that were left out.  Writes calibration.json, calibration.html, extended_model.json
    (the numbers that moved) and calibrated_model.json (all numbers, moved under their priors).
    """
    import helmbench

    from ..api.calibration import FILES

    check_folder(output, FILES, force)
    return find_and_write(
        lambda: helmbench.calibrate(model, train, held_out, positive_rudder=positive_rudder),
        f"{model} cannot be calibrated",
        output,
        as_json,
        quiet,
    )
