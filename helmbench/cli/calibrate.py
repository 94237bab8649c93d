"""`helmbench calibrate --model M --train RECORD... --held-out RECORD... [-o DIR]`."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import click

from ._from_api import TWO_SETS, TwoSets
from ._shared import MODEL, Printer, check_folder, find_and_write, force_option, output_directory, output_options


@click.command(cls=TwoSets, api="calibrate", options=TWO_SETS)
@click.option("--model", required=True, type=MODEL, help="Vessel id or model.json, 3-DOF.")
@output_directory("calibrate-results")
@force_option
@output_options
def calibrate(model: str, output: Path, force: bool, printer: Printer, **asked: Any) -> int:
    """Say which numbers of a model are wrong, and by how much.

    Judged by free runs of records that were left out.  Writes calibration.json, calibration.html, extended_model.json
    (the numbers that moved) and calibrated_model.json (all numbers, moved under their priors).
    """
    import helmbench

    from ..api.calibration import FILES

    check_folder(output, FILES, force)

    def find() -> helmbench.Calibration:
        return helmbench.calibrate(model, **asked)

    return find_and_write(find, f"{model} cannot be calibrated", output, printer)
