"""`helmbench diagnose [--model M] --train RECORD... --held-out RECORD... [-o DIR]`."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import click

from ._from_api import TWO_SETS, TwoSets, several
from ._shared import (
    CAUSE,
    COMMAS,
    FILE,
    MODEL,
    NUMBER,
    NumberRange,
    Printer,
    WholeRange,
    check_folder,
    find_and_write,
    force_option,
    output_directory,
    output_options,
)

OPTIONS = {
    **TWO_SETS,
    "base_parameters": click.Choice(["file", "identify"]),
    "coefficient_sd": NumberRange(min=0.0),
    "channels": COMMAS,
    "causes": several(CAUSE, metavar="CAUSE..."),
    "max_effects": WholeRange(min=1),
    "alpha": NUMBER,
    "seed": WholeRange(min=0),
}


class Diagnose(TwoSets):
    """`diagnose --train RECORD... --held-out RECORD... --causes CAUSE...`"""

    greedy = (*TwoSets.greedy, "--causes")


@click.command(cls=Diagnose, api="diagnose", options=OPTIONS)
@click.option("--model", type=MODEL, help="Vessel id, family id or model.json.  [default: build one from the records]")
@output_directory("diagnose-results")
@click.option("--particulars", type=FILE, help="YAML file of the ship's particulars, without --model.")
@force_option
@output_options
def diagnose(
    model: str | None, output: Path, particulars: Path | None, force: bool, printer: Printer, **asked: Any
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
    show = printer.progress
    sides = {name: asked[name] for name in TWO_SETS}

    def build() -> helmbench.CraftDiagnosis:
        return helmbench.build_model(**sides, particulars=particulars, progress=show)

    if model is None:
        return find_and_write(build, "no model can be built", output, printer)

    def find() -> helmbench.Diagnosis:
        return helmbench.diagnose(model, **asked, progress=show)

    return find_and_write(find, f"{model} cannot be diagnosed", output, printer)
