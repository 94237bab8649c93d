"""`helmbench identify RECORD... --model M [--method X] [-o DIR]`, and `helmbench validate`."""

from __future__ import annotations

import warnings
from collections.abc import Generator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from ._from_api import RECORDS, ApiCommand, several
from ._shared import (
    FAILED,
    FILE,
    METHOD,
    MODEL,
    MODEL_OR_AUTO,
    OK,
    SIDES,
    Printer,
    check_file,
    check_folder,
    complain,
    echo,
    force_option,
    output_options,
    show_files,
    tuning_options,
)

if TYPE_CHECKING:
    from .. import Assessment

OPTIONS = {"validate": RECORDS, "positive_rudder": SIDES, "particulars": FILE}


@click.command(cls=ApiCommand, api="identify", options=OPTIONS, greedy=["--validate", "--compare"])
@click.argument("records", nargs=-1, required=True, metavar="RECORD...", type=FILE)
@click.option(
    "--model", required=True, type=MODEL_OR_AUTO, help="Vessel id, family id, model.json, or auto: the best of all."
)
@click.option(
    "--method",
    type=METHOD,
    help="Method id with options (ls,scheme=midpoint) or path.py:Class.  [default: output-error; none with auto]",
)
@click.option("--compare", multiple=True, metavar="METHOD...", type=METHOD, help="Further methods, side by side.")
@click.option(
    "--identifiability",
    is_flag=True,
    help="Print how well the records determine each parameter, and which manoeuvre would help.",
)
@tuning_options
@click.option("--page", type=FILE, help="Write the page to this HTML file.")
@click.option(
    "-o",
    "--output",
    default="identify-results",
    show_default=True,
    type=FILE,
    help="model.json to write, or a directory for page and model",
)
@force_option
@output_options
def identify(
    records: tuple[Path, ...],
    model: str,
    method: str | None,
    validate: tuple[Path, ...],
    compare: tuple[str, ...],
    positive_rudder: str | None,
    particulars: Path | None,
    identifiability: bool,
    tuner: str | None,
    storage: str | None,
    page: Path | None,
    output: Path,
    force: bool,
    printer: Printer,
) -> int:
    """Identify a model from records and say whether to believe it.

    -o model.json writes the model (a black box has none), -o DIR identification.html, identification.json and
    model.json.  --model auto builds a model from the records: what steers the craft, and what simpler models lack.
    """
    from .. import Assessment, with_tuner
    from ..api import arguments

    into_file = output.suffix == ".json"
    check_file(output, force) if into_file else check_folder(output, Assessment.files, force)
    if page is not None:
        check_file(page, force)
    if model != arguments.AUTO:
        method = method or arguments.METHOD
        if particulars is not None:
            raise click.UsageError("--particulars goes with --model auto.")
    methods = with_tuner(((method, *compare) if method else compare), tuner, storage)
    told = f"method {methods[0]}" if methods else "the ladder"
    with refusals(f"{told} failed on {model}", f"{told} cannot fit {model}") as failed:
        found = _identified(records, model, methods, validate, positive_rudder, particulars)
    if failed:
        return complain(failed[0], FAILED)
    for doubt in found.doubts:
        echo(f"helmbench: warning: {doubt}", err=True)
    paths = _written(found, output, into_file, page)
    printer.show(
        lambda: found.to_json() | {"output": str(output) if output in paths or not into_file else None}, found.summary
    )
    if not printer.hidden:
        for line in found.identifiability.lines() if identifiability and found.identifiability else ():
            echo(line)
        if into_file and output not in paths:
            echo(f"no {output}: a black box has no coefficients", err=True)
        show_files(paths)
    return OK


@contextmanager
def refusals(failed: str, refused: str) -> Generator[list[str]]:
    """A fit that failed fills the list with one line; one that does not apply is bad input."""
    import helmbench

    told: list[str] = []
    try:
        yield told
    except helmbench.CannotFit as reason:
        raise helmbench.BadInput(f"{refused}: {reason}") from None
    except helmbench.FitFailed as reason:
        told.append(f"{failed}: {reason}")


def _identified(
    records: Sequence[Path],
    model: str,
    methods: Sequence[str],
    validate: Sequence[Path],
    positive_rudder: str | None,
    particulars: Path | None,
) -> Assessment:
    """Read every record before anything is fitted, then fit, compare and assess."""
    import helmbench

    from ..api.admission import refuse_copies
    from ..api.arguments import AUTO, as_records
    from ..api.identification import chosen_estimate

    fitters = [helmbench.make_method(text) for text in methods]
    structure = model if model == AUTO else helmbench.resolve(model)
    train, others = (as_records(side, positive_rudder) for side in (records, validate))
    refuse_copies(train, others)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", helmbench.PlausibilityWarning)  # the assessment tells of all records
        if structure != AUTO:
            estimate = helmbench.identify(train, structure, fitters[0])
            if len(fitters) > 1:
                found = helmbench.compare(train, structure, methods, validate=others)
                return estimate.assess(others, compared=found)
            return estimate.assess(others)
        return chosen_estimate(train, methods, others, particulars).assess(others)


def _written(assessment: Assessment, output: Path, into_file: bool, page: Path | None) -> list[Path]:
    """Write model and page; the paths."""
    paths: list[Path] = []
    if not into_file:
        paths += assessment.write(output)
    elif assessment.estimate.predictor is None:
        assessment.estimate.save(output)
        paths.append(output)
    if page is not None:
        paths.append(assessment.write_page(page))
    return paths


# ---- `helmbench validate MODEL RECORD... [--compare MODEL...] [-o DIR]`.


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
