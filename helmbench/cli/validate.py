"""`helmbench validate MODEL RECORD... [--compare MODEL...] [-o DIR]`."""

from __future__ import annotations

import warnings
from pathlib import Path
from typing import Any

import click

from ._from_api import ApiCommand, several
from ._shared import FILE, MODEL, SIDES, Printer, check_file, check_folder, echo, force_option, output_options


@click.command(
    cls=ApiCommand,
    api="validate",
    greedy=["--compare"],
    options={"compare": several(MODEL, metavar="MODEL..."), "positive_rudder": SIDES},
)
@click.argument("model", type=MODEL)
@click.argument("records", nargs=-1, required=True, metavar="RECORD...", type=FILE)
@click.option("-o", "--output", type=FILE, help="Directory for validation.json and validation.html.")
@click.option(
    "--certificate", type=FILE, help="A page on the model: what it was tried on, errors, limits (.html, .pdf)."
)
@force_option
@output_options
def validate(
    model: str,
    records: tuple[Path, ...],
    output: Path | None,
    certificate: Path | None,
    force: bool,
    printer: Printer,
    **asked: Any,
) -> None:
    """Compare simulations with records; nothing is fitted.

    Free runs, predictions ahead, IMO manoeuvring indices.  MODEL is a vessel id or a model.json, extended or not.
    With -o it writes validation.json and a page with the free runs drawn over the records, with --certificate one page
    that says what the model was tried on, how its errors grow with the time ahead, and where its limits are.
    """
    import helmbench

    if output is not None:
        check_folder(output, helmbench.Validation.files, force)
    if certificate is not None:
        check_file(certificate, force)
    with warnings.catch_warnings(record=True) as doubts:
        warnings.simplefilter("always", helmbench.RudderSignWarning)
        found = helmbench.validate(model, records, **asked)
    for doubt in (one for one in doubts if issubclass(one.category, helmbench.RudderSignWarning)):
        echo(f"helmbench: warning: {doubt.message}", err=True)
    paths = found.write(output) if output is not None else ()
    if certificate is not None:
        paths = (*paths, found.write_certificate(certificate))
    printer.show(found.to_json, found.summary, paths)
