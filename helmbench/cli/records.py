"""Commands on records: models of them (identify), simulations beside them (validate, diagnose, calibrate), their own
faults (check)."""

from __future__ import annotations

import warnings
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from ._from_api import EVERY_DAY, GREEDY_SETS, TWO_SETS, Output, command
from ._shared import (
    FILE,
    METHOD,
    MODEL,
    MODEL_OR_AUTO,
    OK,
    RESULTS,
    Printer,
    check_file,
    check_folder,
    echo,
    fit_told,
    show_files,
    tuning_options,
)

if TYPE_CHECKING:
    from .. import Assessment

GIVEN = click.argument("records", nargs=-1, required=True, metavar="RECORD...", type=FILE)

# ---- `helmbench identify RECORD... --model M [--method X] [-o DIR]`.

IDENTIFIED = Output("model.json to write, or a directory for page and model", "identify-results", force=True)


@command("identify", "validate positive_rudder particulars", IDENTIFIED, ["--validate", "--compare"])
@GIVEN
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
def identify(
    records: tuple[Path, ...],
    model: str,
    method: str | None,
    compare: tuple[str, ...],
    identifiability: bool,
    tuner: str | None,
    storage: str | None,
    page: Path | None,
    output: Path,
    force: bool,
    printer: Printer,
    **asked: Any,
) -> None:
    """Identify a model from records and say whether to believe it.

    -o model.json writes the model (a black box has none), -o DIR identification.html, identification.json and
    model.json.  --model auto builds a model from the records: what steers the craft, and what simpler models lack.
    """
    from .. import Assessment, with_tuner
    from ..api import arguments

    into_file = output.suffix == ".json"
    check_file(output, force) if into_file else check_folder(output, Assessment.files, force)
    check_file(page, force)
    if model != arguments.AUTO:
        method = method or arguments.METHOD
        if asked["particulars"] is not None:
            raise click.UsageError("--particulars goes with --model auto.")
    methods = with_tuner(((method, *compare) if method else compare), tuner, storage)
    told = f"method {methods[0]}" if methods else "the ladder"
    with fit_told(f"{told} cannot fit {model}", f"{told} failed on {model}"):
        found = _identified(records, model, methods, **asked)
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

    from ..api.arguments import AUTO, as_records
    from ..api.identification import check_no_copies, chosen_estimate

    fitters = [helmbench.make_method(text) for text in methods]
    structure = model if model == AUTO else helmbench.resolve(model)
    train, others = (as_records(side, positive_rudder) for side in (records, validate))
    check_no_copies(train, others)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", helmbench.PlausibilityWarning)  # the assessment tells of all records
        if structure == AUTO:
            return chosen_estimate(train, methods, others, particulars).assess(others)
        estimate = helmbench.identify(train, structure, fitters[0])
        several = len(methods) > 1
        found = helmbench.compare(train, structure, methods, validate=others) if several else None
        return estimate.assess(others, compared=found)


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

VALIDATED = Output("Directory for validation.json and validation.html.", writes="Validation")


@command("validate", "compare positive_rudder", VALIDATED, ["--compare"])
@click.argument("model", type=MODEL)
@GIVEN
@click.option(
    "--certificate", type=FILE, help="A page on the model: what it was tried on, errors, limits (.html, .pdf)."
)
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


# ---- `helmbench diagnose [--model M] --train RECORD... --held-out RECORD... [-o DIR]`.

DIAGNOSE_OPTIONS = f"{TWO_SETS} base_parameters coefficient_sd channels causes max_effects alpha seed"
DIAGNOSED = Output(RESULTS, "diagnose-results", "Diagnosis")


@command("diagnose", DIAGNOSE_OPTIONS, DIAGNOSED, [*GREEDY_SETS, "--causes"], EVERY_DAY)
@click.option("--model", type=MODEL, help="Vessel id, family id or model.json.  [default: build one from the records]")
@click.option("--particulars", type=FILE, help="YAML file of the ship's particulars, without --model.")
def diagnose(model: str | None, particulars: Path | None, output: Path, printer: Printer, **asked: Any) -> None:
    """Name what a model gets wrong, extend it, measure the gain.

    Writes diagnosis.json, diagnosis.html and extended_model.json.  Without --model the records tell what steers the
    craft and what simpler models lack, and a model is built.
    """
    import helmbench

    if particulars is not None and model is not None:
        raise click.UsageError("--particulars goes without --model: a file of particulars is a model as well.")
    with fit_told("no model can be built" if model is None else f"{model} cannot be diagnosed"):
        if model is None:
            sides = {name: asked[name] for name in TWO_SETS.split()}
            found = helmbench.build_model(**sides, particulars=particulars, progress=printer.progress)
        else:
            found = helmbench.diagnose(model, **asked, progress=printer.progress)
    printer.show(found.to_json, found.summary, found.write(output))


# ---- `helmbench calibrate --model M --train RECORD... --held-out RECORD... [-o DIR]`.


@command("calibrate", TWO_SETS, Output(RESULTS, "calibrate-results", "Calibration"), GREEDY_SETS, EVERY_DAY)
@click.option("--model", required=True, type=MODEL, help="Vessel id or model.json, 3-DOF.")
def calibrate(model: str, output: Path, printer: Printer, **asked: Any) -> None:
    """Say which numbers of a model are wrong, and by how much.

    Judged by free runs of pieces of records that were left out, as `diagnose` does.  Writes calibration.json,
    calibration.html, extended_model.json (what was named) and calibrated_model.json (all numbers, moved under their
    priors).
    """
    import helmbench

    with fit_told(f"{model} cannot be calibrated"):
        found = helmbench.calibrate(model, **asked)
    printer.show(found.to_json, found.summary, found.write(output))


# ---- `helmbench check RECORD... [-o DIR]`.

MATTERS = 1
"""Exit status where a finding matters."""


@command("check", "positive_rudder", Output("directory for check.json and check.html", writes="Check"))
@GIVEN
def check(records: tuple[Path, ...], output: Path | None, printer: Printer, **asked: Any) -> int:
    """Name the faults of sensors and files; needs no model.

    Time stamps, frozen samples, jumps, units, signs, exchanged columns; biases, scales, delays and offsets of heading,
    yaw rate, velocities and positions.  Exit status 0: nothing that matters, 1: a finding that matters.
    """
    import helmbench

    found = helmbench.check(records, **asked)
    paths = () if output is None else found.write(output)
    printer.show(found.to_json, found.summary, paths)
    return MATTERS if any(finding.material for finding in found.findings) else OK
