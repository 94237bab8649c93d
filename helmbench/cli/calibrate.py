"""`helmbench calibrate --model M --train RECORD... --held-out RECORD... -o DIR`."""

from __future__ import annotations

from pathlib import Path

import click

from ._shared import FAILED, FILE, OK, SIDES, Greedy, check_folder, complain, output_options, print_json


class Calibrate(Greedy):
    """`calibrate --train RECORD... --held-out RECORD...`"""

    greedy = ("--train", "--held-out")


@click.command(cls=Calibrate)
@click.option("--model", required=True, help="Vessel id or model.json, 3-DOF.")
@click.option("--train", multiple=True, required=True, metavar="RECORD...", type=FILE, help="Records.")
@click.option("--held-out", multiple=True, metavar="RECORD...", type=FILE, help="Records that are scored at the end.")
@click.option("--positive-rudder", type=SIDES, help="Side of a positive rudder in the files; overrides their sidecars.")
@click.option("-o", "--output", required=True, type=FILE, help="directory of the results")
@output_options
def calibrate(
    model: str,
    train: tuple[Path, ...],
    held_out: tuple[Path, ...],
    positive_rudder: str | None,
    output: Path,
    as_json: bool,
    quiet: bool,
) -> int:
    """Find which numbers of a model are wrong and by how much, by free runs of records that were left out.

    Writes calibration.json, calibration.html and calibrated_model.json.
    """
    import helmbench

    check_folder(output)
    try:
        found = helmbench.calibrate(model, train, held_out, positive_rudder=positive_rudder)
    except helmbench.CannotFit as reason:
        raise helmbench.BadInput(f"{model} cannot be calibrated: {reason}") from None
    except helmbench.FitFailed as reason:
        return complain(f"{model} cannot be calibrated: {reason}", FAILED)
    paths = found.write(output)
    if as_json:
        print_json(found.to_json())
    elif not quiet:
        click.echo(found.summary())
        click.echo("\n".join(f"wrote {path}" for path in paths), err=True)
    return OK
