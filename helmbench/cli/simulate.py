"""`helmbench simulate VESSEL --manoeuvre ... -o record.csv`."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import click

from ._from_api import ApiCommand
from ._shared import FILE, NUMBER, SIDES, VESSEL, Printer, WholeRange, check_file, force_option, output_options

OPTIONS = {
    "manoeuvre": click.STRING,
    "duration_s": NUMBER,
    "dt_s": NUMBER,
    "noise": click.STRING,
    "disturbance": click.STRING,
    "seed": WholeRange(min=0),
}


@click.command(cls=ApiCommand, api="simulate", options=OPTIONS)
@click.argument("vessel", type=VESSEL)
@click.option("--positive-rudder", type=SIDES, help="Side of a positive rudder in the file; default: the vessel's.")
@click.option(
    "-o", "--output", default="record.csv", show_default=True, type=FILE, help="record.csv or .parquet to write"
)
@force_option
@output_options
def simulate(
    vessel: str, positive_rudder: str | None, output: Path, force: bool, printer: Printer, **asked: Any
) -> None:
    """Simulate a manoeuvre; writes a record with its sidecar."""
    import helmbench

    check_file(output, force)
    record = helmbench.simulate(vessel, **asked)
    record = record.turned(positive_rudder) if positive_rudder else record
    helmbench.write_record(record, output)
    facts = {"record": str(output), "vessel": vessel, "samples": record.n, "dt_s": record.dt}
    more = {"channels": list(record.channels), "positive_rudder": record.meta.positive_rudder}
    told = f"{output}: {record.n} samples every {record.dt:g} s, {', '.join(record.channels)}"
    printer.show(lambda: facts | more, lambda: told)
