"""`helmbench check RECORD... [-o DIR]`."""

from __future__ import annotations

from pathlib import Path

import click

from ._from_api import ApiCommand
from ._shared import FILE, OK, SIDES, Printer, check_folder, force_option, output_options

MATTERS = 1
"""Exit status where a finding matters."""


@click.command(cls=ApiCommand, api="check", options={"positive_rudder": SIDES})
@click.argument("records", nargs=-1, required=True, metavar="RECORD...", type=FILE)
@click.option("-o", "--output", type=FILE, help="directory for check.json and check.html")
@force_option
@output_options
def check(
    records: tuple[Path, ...], positive_rudder: str | None, output: Path | None, force: bool, printer: Printer
) -> int:
    """Name the faults of sensors and files; needs no model.

    Time stamps, frozen samples, jumps, units, signs, exchanged columns; biases, scales, delays and offsets of heading,
    yaw rate, velocities and positions.  Exit status 0: nothing that matters, 1: a finding that matters.
    """
    import helmbench

    from ..api.check import FILES

    if output is not None:
        check_folder(output, FILES, force)
    found = helmbench.check(records, positive_rudder=positive_rudder)
    paths = () if output is None else found.write(output)
    printer.show(found.to_json, found.summary, paths)
    return MATTERS if any(finding.material for finding in found.findings) else OK
