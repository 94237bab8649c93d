"""`helmbench import RAW... -o record.csv`."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from ._from_api import Output, command
from ._shared import BAD_INPUT, FILE, OK, RECORD, Printer, complain, confirmed, echo, print_json

if TYPE_CHECKING:
    from .. import Import, ImportDraft

OPTIONS = "segment vessel positive_rudder step_s variation_deg"


@command("import_log", OPTIONS, Output(RECORD, "record.csv", "a file"), name="import")
@click.argument("logs", nargs=-1, required=True, metavar="RAW...", type=FILE)
@click.option(
    "--map", "mapping", type=FILE, help="Mapping of the columns; the draft is written there if it does not exist."
)
@click.option("--yes", is_flag=True, help="Import without asking; stops where something is open.")
def import_command(
    logs: tuple[Path, ...],
    mapping: Path | None,
    yes: bool,
    output: Path,
    force: bool,
    printer: Printer,
    **asked: Any,
) -> int:
    """Read raw logs of any make as records.

    CSV, Excel, MAT, HDF5, netCDF, NMEA, ROS, GPX and autopilots' logs.  What every column is, its unit and sign are
    taken from the file, from its other channels and from what is physically possible, and shown; what none of these
    tells is asked, on the terminal or in the file of --map, and --yes stops at it (--json prints the questions).  A log
    without a rudder becomes a record without one, one with a roll of unknown sign a record without roll.  The mapping
    goes beside the record (STEM.map.yaml) for the next log, columns that are no channel go to STEM.aside.csv.
    """
    import helmbench

    known = mapping if mapping is not None and mapping.exists() else None
    draft = helmbench.draft_import(logs, mapping=known, **asked)
    if not (yes or printer.hidden or mapping is not None) and sys.stdin.isatty():
        draft = _asked(draft)
    ids: set[str] = set()
    while yes and {q.id for q in draft.questions} - ids and all(question.without for question in draft.questions):
        ids |= {question.id for question in draft.questions}
        for question in draft.questions:
            echo(f"{question.text} Imported without it, by --yes; answer it with --map", err=True)
        draft = draft.answer({question.id: question.without for question in draft.questions})
    try:
        found = draft.import_log()
    except helmbench.BadInput:
        if printer.as_json:
            print_json(draft.to_dict())
        else:
            echo(draft.summary(), err=True)
        if mapping is not None and known is None and draft.mapping is not None:
            draft.write_mapping(mapping)
            echo(f"wrote {mapping} with every column: answer what is asked in it, then repeat the command", err=True)
        raise
    if not printer.hidden:
        echo(found.summary())
    if known is None and not yes and not _confirmed(found, mapping, printer.hidden):
        if mapping is None:
            hint = f"repeat it with --yes, or with --map {output.stem}.map.yaml to write the draft there and change it"
            return complain(f"nothing imported: the mapping is not confirmed; {hint}", BAD_INPUT)
        return OK
    paths = found.write(output, force=force)
    printer.show(lambda: found.to_dict() | {"files": [str(path) for path in paths]}, files=paths)
    return OK


def _asked(draft: ImportDraft) -> ImportDraft:
    """The draft after its questions were asked on the terminal, one after another."""
    skipped: set[str] = set()
    while question := next((q for q in draft.questions if q.id not in skipped), None):
        echo(question.text)
        for number, answer in enumerate(question.answers, start=1):
            echo(f"  {number}: {answer.text}")
        more = f", or = and {question.number}" if question.number else ""
        given = click.prompt(f"number of the answer{more} (empty: leave open)", default="", show_default=False).strip()
        keys = {str(number): answer.key for number, answer in enumerate(question.answers, start=1)}
        key = given.removeprefix("=").strip() if given.startswith("=") else keys.get(given, "")
        if not key:
            skipped.add(question.id)
            continue
        draft = draft.answer({question.id: key})
    return draft


def _confirmed(found: Import, mapping: Path | None, hidden: bool) -> bool:
    """Whether the guess is confirmed on the terminal; with --map it is written there to be looked at."""
    if mapping is not None:
        found.write_mapping(mapping)
        echo(f"wrote {mapping}: look at it, then repeat the command; nothing imported yet", err=True)
        return False
    return not hidden and sys.stdin.isatty() and confirmed("import the log with this mapping?")
