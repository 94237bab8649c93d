"""`helmbench import RAW... -o record.csv`."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import TYPE_CHECKING

import click

from ._shared import (
    BAD_INPUT,
    FILE,
    OK,
    SIDES,
    check_file,
    complain,
    confirmed,
    force_option,
    output_options,
    print_json,
    show_files,
)

if TYPE_CHECKING:
    from .. import Import


@click.command("import")
@click.argument("logs", nargs=-1, required=True, metavar="RAW...", type=FILE)
@click.option(
    "--map", "mapping", type=FILE, help="Mapping of the columns; written with the guess if it does not exist."
)
@click.option("--yes", is_flag=True, help="Take the guessed mapping without asking.")
@click.option("--segment", is_flag=True, help="Cut into zigzags, turns and straight runs, a record each.")
@click.option("--vessel", help="Vessel id, for the sidecar.")
@click.option("--positive-rudder", type=SIDES, help="Side of a positive rudder; default: told by the yaw response.")
@click.option("--dt", "step_s", type=float, help="Time step in seconds; default: that of the slowest logger.")
@click.option(
    "--variation", "variation_deg", type=float, help="Magnetic variation, deg to east, for magnetic headings."
)
@click.option("-o", "--output", required=True, type=FILE, help="record.csv or record.parquet")
@force_option
@output_options
def import_command(
    logs: tuple[Path, ...],
    mapping: Path | None,
    yes: bool,
    segment: bool,
    vessel: str | None,
    positive_rudder: str | None,
    step_s: float | None,
    variation_deg: float | None,
    output: Path,
    force: bool,
    as_json: bool,
    quiet: bool,
) -> int:
    """Read raw logs of any make (CSV, Excel, MAT, NMEA 0183) as records.

    Columns, units and signs are guessed and shown; they are confirmed on the terminal, by --yes or by --map.  The
    mapping goes beside the record (STEM.map.yaml) for the next log, columns that are no channel go to STEM.aside.csv.
    """
    import helmbench

    check_file(output, force)
    known = mapping if mapping is not None and mapping.exists() else None
    try:
        found = helmbench.import_log(
            logs,
            mapping=known,
            vessel=vessel,
            positive_rudder=positive_rudder,
            step_s=step_s,
            variation_deg=variation_deg,
            segment=segment,
        )
    except helmbench.BadInput as error:
        _show_faults(error)
        if mapping is not None and known is None:
            _write_draft(error, mapping)
        raise
    if not (quiet or as_json):
        click.echo(found.summary())
    if known is None and not yes and not _confirmed(found, mapping, quiet or as_json):
        if mapping is None:
            hint = f"repeat it with --yes, or with --map {output.stem}.map.yaml to write the guess there and change it"
            return complain(f"nothing imported: the mapping is not confirmed; {hint}", BAD_INPUT)
        return OK
    paths = found.write(output, force=force)
    if as_json:
        print_json(found.to_dict() | {"files": [str(path) for path in paths]})
    elif not quiet:
        show_files(paths)
    return OK


def _confirmed(found: Import, mapping: Path | None, hidden: bool) -> bool:
    """Whether the guess is confirmed on the terminal; with --map it is written there to be looked at."""
    if mapping is not None:
        found.write_mapping(mapping)
        click.echo(f"wrote {mapping}: look at it, then repeat the command; nothing imported yet", err=True)
        return False
    return not hidden and sys.stdin.isatty() and confirmed("import the log with this mapping?")


def _show_faults(error: Exception) -> None:
    """Print columns and faults of a failed import, where there is more than the one line of the error to say."""
    from ..reporting.importing import faults_text

    faults = getattr(error, "faults", ())
    columns = getattr(error, "columns", ())
    if len(faults) > 1 or columns:
        click.echo(faults_text(columns, faults), err=True)


def _write_draft(error: Exception, mapping: Path) -> None:
    """Write all that was guessed of a log that cannot be imported so, to be changed by hand."""
    from ..api.importing import write_mapping

    draft = getattr(error, "draft", None)
    if draft is not None:
        write_mapping(draft, mapping)
        click.echo(f"wrote {mapping} with every guess: change it, then repeat the command", err=True)
