"""`helmbench doctor`."""

from __future__ import annotations

import click

from ._shared import FAILED, OK, Printer, echo, output_options


@click.command()
@output_options
def doctor(printer: Printer) -> int:
    """Look at what helmbench needs on this machine.

    Packages, compiled code, data, threads, disk, permissions: each line is ok, a warning or a fault, with what to do.
    Exit status 1 where there is a fault.
    """
    import helmbench

    found = helmbench.doctor()
    printer.show(found.to_json, found.summary)
    faults = [one for one in found.findings if one.status == "fault"]
    if faults and printer.quiet and not printer.as_json:
        echo("\n".join(f"{one.what}: {one.told}; {one.todo}" for one in faults), err=True)
    return FAILED if found.status == "fault" else OK
