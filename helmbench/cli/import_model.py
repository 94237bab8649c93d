"""`helmbench import-model TABLE --family FAMILY --positive-rudder SIDE -o model.json`."""

from __future__ import annotations

from pathlib import Path

import click

from ._shared import FILE, NUMBER, check_file, force_option, output_options, print_json, show_files


@click.command("import-model")
@click.argument("table", type=FILE)
@click.option("--family", required=True, help="Equations that the parameters belong to, such as abkowitz.")
@click.option("--positive-rudder", required=True, type=click.Choice(("port", "starboard")), help="Side it turns to.")
@click.option("--speed", type=NUMBER, help="Speed of the straight course, m/s.")
@click.option("--revolutions", type=NUMBER, help="Revolutions of the straight course, 1/s.")
@click.option("-o", "--output", default="model.json", show_default=True, type=FILE, help="model.json to write.")
@force_option
@output_options
def import_model(
    table: Path,
    family: str,
    positive_rudder: str,
    speed: float | None,
    revolutions: float | None,
    output: Path,
    force: bool,
    as_json: bool,
    quiet: bool,
) -> None:
    """Make a model from a published table of parameters.

    TABLE is CSV, YAML or JSON of names, values and units.
    """
    import helmbench
    from helmbench.models.model import model_to_json

    check_file(output, force)
    model = helmbench.read_parameters(
        table, family, positive_rudder=positive_rudder, speed_m_s=speed, n0_rps=revolutions
    )
    model_to_json(model, output)
    if as_json:
        print_json({"table": str(table), "family": family, "output": str(output)})
    elif not quiet:
        show_files([output])
