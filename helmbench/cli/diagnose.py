"""`helmbench diagnose [--model M] --train RECORD... --held-out RECORD... [-o DIR]`."""

from __future__ import annotations

from pathlib import Path

import click

from ._shared import (
    CAUSE,
    FILE,
    MODEL,
    NUMBER,
    NumberRange,
    TwoSets,
    WholeRange,
    check_folder,
    find_and_write,
    force_option,
    output_options,
    shows_progress,
    two_sets_options,
)


class Diagnose(TwoSets):
    """`diagnose --train RECORD... --held-out RECORD... --causes CAUSE...`"""

    greedy = (*TwoSets.greedy, "--causes")


@click.command(cls=Diagnose)
@click.option("--model", type=MODEL, help="Vessel id, family id or model.json.  [default: build one from the records]")
@two_sets_options("Records to name the causes with.", "Records to measure the gain with.", "diagnose-results")
@click.option(
    "--base-parameters",
    type=click.Choice(["file", "identify"]),
    help="Take the model's coefficients as known, or estimate them with the causes.  [default: file where it has any]",
)
@click.option(
    "--coefficient-sd",
    type=NumberRange(min=0.0),
    help="Relative uncertainty of known coefficients; 0: exact.  [default: the family's priors]",
)
@click.option("--particulars", type=FILE, help="YAML file of the ship's particulars, without --model.")
@click.option("--channels", help="Use only these: heading,yaw_rate,surge,sway,north,east.  [default: all]")
@click.option("--causes", multiple=True, metavar="CAUSE...", type=CAUSE, help="Test only these causes.  [default: all]")
@click.option(
    "--max-effects", type=WholeRange(min=1), default=3, show_default=True, help="Largest number of causes to name."
)
@click.option(
    "--alpha", type=NUMBER, default=0.01, show_default=True, help="Family-wise error level of the whole diagnosis."
)
@click.option("--seed", type=WholeRange(min=0), default=0, show_default=True)
@force_option
@output_options
def diagnose(
    model: str | None,
    train: tuple[Path, ...],
    held_out: tuple[Path, ...],
    base_parameters: str | None,
    coefficient_sd: float | None,
    particulars: Path | None,
    channels: str | None,
    causes: tuple[str, ...],
    max_effects: int,
    alpha: float,
    seed: int,
    positive_rudder: str | None,
    output: Path,
    force: bool,
    as_json: bool,
    quiet: bool,
) -> int:
    """Name what a model gets wrong, extend it, measure the gain.

    Writes diagnosis.json, diagnosis.html and extended_model.json.  Without --model the records tell what steers the
    craft and what simpler models lack, and a model is built.
    """
    import helmbench

    from ..api.diagnosis import FILES

    check_folder(output, FILES, force)
    if particulars is not None and model is not None:
        raise click.UsageError("--particulars goes without --model: a file of particulars is a model as well.")

    def build() -> helmbench.CraftDiagnosis:
        return helmbench.build_model(
            train,
            held_out,
            positive_rudder=positive_rudder,
            particulars=particulars,
            progress=shows_progress(quiet or as_json),
        )

    if model is None:
        return find_and_write(build, "no model can be built", output, as_json, quiet)

    def find() -> helmbench.Diagnosis:
        return helmbench.diagnose(
            model,
            train,
            held_out,
            base_parameters=base_parameters,
            coefficient_sd=coefficient_sd,
            channels=None if channels is None else [name.strip() for name in channels.split(",")],
            max_effects=max_effects,
            alpha=alpha,
            seed=seed,
            causes=causes or None,
            positive_rudder=positive_rudder,
            progress=shows_progress(quiet or as_json),
        )

    return find_and_write(find, f"{model} cannot be diagnosed", output, as_json, quiet)
