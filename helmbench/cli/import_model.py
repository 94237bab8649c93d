"""`helmbench import-model TABLE --family FAMILY --positive-rudder SIDE -o model.json`."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import click

from ._from_api import ApiCommand
from ._shared import FILE, NUMBER, SIDES, Printer, check_file, force_option, output_options

OPTIONS = {
    "family": click.STRING,
    "positive_rudder": SIDES,
    "speed_m_s": NUMBER,
    "n0_rps": {"type": NUMBER, "flag": "--revolutions"},
}


@click.command("import-model", cls=ApiCommand, api="read_parameters", options=OPTIONS)
@click.argument("table", type=FILE)
@click.option("-o", "--output", default="model.json", show_default=True, type=FILE, help="model.json to write.")
@force_option
@output_options
def import_model(table: Path, output: Path, force: bool, printer: Printer, **asked: Any) -> None:
    """Make a model from a published table of parameters.

    TABLE is CSV, YAML or JSON of names, values and units.
    """
    import helmbench
    from helmbench.models.model import model_to_json

    check_file(output, force)
    model = helmbench.read_parameters(table, **asked)
    model_to_json(model, output)
    printer.show(lambda: {"table": str(table), "family": asked["family"], "output": str(output)}, files=[output])
