"""Commands that say what is wrong: with a simulation (diagnose), its numbers (calibrate), the records (check)."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import click

from ._from_api import EVERY_DAY, GREEDY_SETS, TWO_SETS, ApiCommand, several
from ._shared import (
    CAUSE,
    COMMAS,
    FILE,
    MODEL,
    NUMBER,
    OK,
    SIDES,
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


@click.command(cls=ApiCommand, api="diagnose", options=OPTIONS, greedy=[*GREEDY_SETS, "--causes"], common=EVERY_DAY)
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

    check_folder(output, helmbench.Diagnosis.files, force)
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


# ---- `helmbench calibrate --model M --train RECORD... --held-out RECORD... [-o DIR]`.


@click.command(cls=ApiCommand, api="calibrate", options=TWO_SETS, greedy=GREEDY_SETS, common=EVERY_DAY)
@click.option("--model", required=True, type=MODEL, help="Vessel id or model.json, 3-DOF.")
@output_directory("calibrate-results")
@force_option
@output_options
def calibrate(model: str, output: Path, force: bool, printer: Printer, **asked: Any) -> int:
    """Say which numbers of a model are wrong, and by how much.

    Judged by free runs of records that were left out.  Writes calibration.json, calibration.html, extended_model.json
    (the numbers that moved) and calibrated_model.json (all numbers, moved under their priors).
    """
    import helmbench

    check_folder(output, helmbench.Calibration.files, force)

    def find() -> helmbench.Calibration:
        return helmbench.calibrate(model, **asked)

    return find_and_write(find, f"{model} cannot be calibrated", output, printer)


# ---- `helmbench check RECORD... [-o DIR]`.

MATTERS = 1
"""Exit status where a finding matters."""


@click.command(cls=ApiCommand, api="check", options={"positive_rudder": SIDES})
@click.argument("records", nargs=-1, required=True, metavar="RECORD...", type=FILE)
@click.option("-o", "--output", type=FILE, help="directory for check.json and check.html")
@force_option
@output_options
def check(
    records: tuple[Path, ...], positive_rudder: str | None, output: Path | None, force: bool, printer: Printer
) -> int:
    """Name the faults of sensors and files; needs no model.

    Time stamps, frozen samples, jumps, units, signs, exchanged columns; biases, scales, delays and offsets of heading,
    yaw rate, velocities and positions.  Exit status 0: nothing that matters, 1: a finding that matters.
    """
    import helmbench

    if output is not None:
        check_folder(output, helmbench.Check.files, force)
    found = helmbench.check(records, positive_rudder=positive_rudder)
    paths = () if output is None else found.write(output)
    printer.show(found.to_json, found.summary, paths)
    return MATTERS if any(finding.material for finding in found.findings) else OK
