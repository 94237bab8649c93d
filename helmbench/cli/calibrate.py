"""`helmbench calibrate --model M --train RECORD... --held-out RECORD... -o DIR`."""

from __future__ import annotations

from pathlib import Path

import click

from ._shared import (
    FAILED,
    MODEL,
    OK,
    TwoSets,
    check_folder,
    complain,
    force_option,
    output_options,
    show_written,
    two_sets_options,
)


@click.command(cls=TwoSets)
@click.option("--model", required=True, type=MODEL, help="Vessel id or model.json, 3-DOF.")
@two_sets_options("Records.", "Records that are scored at the end.")
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
    """Find which numbers of a model are wrong and by how much, by free runs of records that were left out.

    Writes calibration.json, calibration.html and calibrated_model.json.
    """
    import helmbench

    from ..api.calibration import FILES

    check_folder(output, FILES, force)
    try:
        found = helmbench.calibrate(model, train, held_out, positive_rudder=positive_rudder)
    except helmbench.CannotFit as reason:
        raise helmbench.BadInput(f"{model} cannot be calibrated: {reason}") from None
    except helmbench.FitFailed as reason:
        return complain(f"{model} cannot be calibrated: {reason}", FAILED)
    show_written(found, output, as_json, quiet)
    return OK
