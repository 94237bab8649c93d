"""`helmbench identify RECORD... --model M --method X -o model.json`."""

from __future__ import annotations

import warnings
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from ._shared import FAILED, FILE, OK, SIDES, Greedy, check_file, complain, output_options, print_json, tuning_options

if TYPE_CHECKING:
    from .. import Estimate, Record
    from ..estimation.identifiability import Identifiability


class Identify(Greedy):
    """`identify RECORD... --validate RECORD...`"""

    greedy = ("--validate",)


@dataclass(frozen=True)
class Outcome:
    """What is printed: estimate, names of the records, scores on validation records, warnings, identifiability."""

    estimate: Estimate
    train: list[str]
    validation: list[str]
    scores: dict[str, Any]
    warnings: list[str]
    identifiability: Identifiability | None


@click.command(cls=Identify)
@click.argument("records", nargs=-1, required=True, metavar="RECORD...", type=FILE)
@click.option("--model", required=True, help="Vessel id, family id or model.json.")
@click.option("--method", required=True, help="Method id with options (ls,scheme=midpoint) or path.py:Class.")
@click.option("--validate", multiple=True, metavar="RECORD...", type=FILE, help="Held-out records.")
@click.option("--positive-rudder", type=SIDES, help="Side of a positive rudder in the files; overrides their sidecars.")
@click.option(
    "--identifiability",
    is_flag=True,
    help="Report how well the records determine each parameter, and which manoeuvre would help.",
)
@tuning_options
@click.option("-o", "--output", required=True, type=FILE, help="model.json to write")
@output_options
def identify(
    records: tuple[Path, ...],
    model: str,
    method: str,
    validate: tuple[Path, ...],
    positive_rudder: str | None,
    identifiability: bool,
    tuner: str | None,
    storage: str | None,
    output: Path,
    as_json: bool,
    quiet: bool,
) -> int:
    """Identify a model from records, score it on others and write it as a model file (a black box has none)."""
    from .. import BadInput, CannotFit, FitFailed, with_tuner

    check_file(output)
    (method,) = with_tuner((method,), tuner, storage)
    try:
        found = _identify(model, method, records, validate, positive_rudder, identifiability)
    except CannotFit as reason:
        raise BadInput(f"method {method} cannot fit {model}: {reason}") from None
    except FitFailed as reason:
        return complain(f"{method} failed on {model}: {reason}", FAILED)
    for doubt in found.warnings:
        click.echo(f"helmbench: warning: {doubt}", err=True)
    written = found.estimate.predictor is None
    if written:
        found.estimate.save(output)
    if as_json:
        print_json(as_dict(found) | {"output": str(output) if written else None})
    elif not quiet:
        _print(found, output)
    return OK


def _identify(
    model: str,
    method: str,
    train: Sequence[Path],
    validate: Sequence[Path],
    positive_rudder: str | None,
    identifiability: bool,
) -> Outcome:
    """Read every record before anything is fitted, then fit and score."""
    import helmbench

    from ..api.identification import refuse_copies

    structure, fitter = helmbench.resolve(model), helmbench.make_method(method)
    records = [helmbench.read_record(path, positive_rudder) for path in train]
    others = [helmbench.read_record(path, positive_rudder) for path in validate]
    refuse_copies(records, others)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", helmbench.RudderSignWarning)  # printed below, for validation records as well
        estimate = helmbench.identify(records, structure, fitter)
    doubts = [helmbench.rudder_sign_doubt(record, structure) for record in (*records, *others)]
    return Outcome(
        estimate=estimate,
        train=_names(records),
        validation=_names(others),
        scores=estimate.score(others) if others else {},
        warnings=[doubt for doubt in doubts if doubt],
        identifiability=estimate.identifiability(records) if identifiability and estimate.predictor is None else None,
    )


def _names(records: Sequence[Record]) -> list[str]:
    return [record.name for record in records]


def as_dict(found: Outcome) -> dict[str, Any]:
    """Plain values for `--json`."""
    estimate, model = found.estimate, found.estimate.model
    values, errors = estimate.parameters, estimate.stderr
    parameters = [
        {"parameter": name, "unit": unit, "estimate": values[name], "stderr": errors.get(name)}
        for name, unit in zip(model.parameter_names, model.parameter_units, strict=True)
        if name in values
    ]
    return {
        "method": estimate.method,
        "variant": estimate.variant,
        "model": model.family,
        "positive_rudder": model.positive_rudder,
        "train": found.train,
        "parameters": parameters,
        "converged": estimate.converged,
        "message": estimate.message,
        "wall_s": estimate.wall_s,
        "cpu_s": estimate.cpu_s,
        "validation": {"records": found.validation, **found.scores} if found.validation else None,
        "profile": estimate.extra.get("profile"),
        "identifiability": found.identifiability.as_dict() if found.identifiability else None,
        "warnings": found.warnings,
    }


def _print(found: Outcome, output: Path) -> None:
    from ..api.documents import parameters_text, scores_text

    estimate = found.estimate
    state = "" if estimate.converged else f", not converged: {estimate.message}"
    click.echo(f"{estimate.model.family} by {estimate.method} from {', '.join(found.train)}{state}")
    click.echo(parameters_text(estimate))
    for line in found.identifiability.lines() if found.identifiability else ():
        click.echo(line)
    if found.validation:
        click.echo(f"validation on {', '.join(found.validation)}{' (diverged)' if found.scores['diverged'] else ''}")
        click.echo(scores_text(found.scores))
    click.echo(f"wrote {output}" if estimate.predictor is None else f"no {output}: a black box has no coefficients")
