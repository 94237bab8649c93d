"""`helmbench doctor`."""

from __future__ import annotations

import click

from ._shared import FAILED, OK, echo, output_options, print_json


@click.command()
@output_options
def doctor(as_json: bool, quiet: bool) -> int:
    """Look at what helmbench needs on this machine.

    Packages, compiled code, data, threads, disk, permissions: each line is ok, a warning or a fault, with what to do.
    Exit status 1 where there is a fault.
    """
    import helmbench

    found = helmbench.doctor()
    if as_json:
        print_json(found.to_json())
    elif not quiet:
        echo(found.summary())
    elif faults := [one for one in found.findings if one.status == "fault"]:
        echo("\n".join(f"{one.what}: {one.told}; {one.todo}" for one in faults), err=True)
    return FAILED if found.status == "fault" else OK
