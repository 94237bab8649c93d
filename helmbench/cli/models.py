"""Commands on models: list, simulate, export, import-model, from-indices."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from ._from_api import Output, command
from ._shared import FILE, FORMATS, MODEL, RECORD, SIDES, VESSEL, Printer, echo, fit_told, print_json

if TYPE_CHECKING:
    from ..methods.options import Option


# ---- `helmbench list KIND`.

LISTED = ("models", "vessels", "manoeuvres", "methods", "causes", "diagnosers", "suites")


@click.command("list")
@click.argument("kind", type=click.Choice(LISTED), metavar="|".join(LISTED))
@click.argument("name", required=False)
@click.option("--json", "as_json", is_flag=True, help="Print JSON for machines.")
def list_command(kind: str, name: str | None, as_json: bool) -> None:
    """List what there is: models, vessels, methods, causes, suites.

    `list methods NAME` lists the options of a method.
    """
    import helmbench

    from ..reporting.tables import Cell, Table, console

    if name is None:
        found: dict[str, str] = getattr(helmbench, f"list_{kind}")()
        plain = [{"id": name, "title": title} for name, title in found.items()]
        text = console(Table(("", ""), tuple((Cell(name), Cell(title)) for name, title in found.items())))
    elif kind == "methods":
        options = helmbench.method_options(name)
        plain, text = [option.texts() for option in options], _options_text(options)
    else:
        hint = "'list methods NAME' lists the options of a method"
        raise helmbench.BadInput(f"list {kind} takes no name", hint=hint)
    print_json(plain) if as_json else echo(text)


def _options_text(options: Sequence[Option]) -> str:
    """Options of a method with default, meaning, allowed values and searched range, a block each."""
    lines: list[str] = []
    for option in options:
        lines.append(f"{option.name}={option.default}")
        lines += [f"    {option.meaning}"] if option.meaning else []
        lines += [f"    allowed: {option.range}"] if option.range else []
        lines += [f"    tuning searches {option.searched}"] if option.searched else []
    return "\n".join(lines) or "no options"


# ---- `helmbench simulate VESSEL --manoeuvre ... -o record.csv`.

SIMULATE_OPTIONS = "manoeuvre duration_s dt_s noise disturbance seed"


@command("simulate", SIMULATE_OPTIONS, Output(RECORD, "record.csv", "a file"))
@click.argument("vessel", type=VESSEL)
@click.option("--positive-rudder", type=SIDES, help="Side of a positive rudder in the file; default: the vessel's.")
def simulate(vessel: str, positive_rudder: str | None, output: Path, printer: Printer, **asked: Any) -> None:
    """Simulate a manoeuvre; writes a record with its sidecar."""
    import helmbench

    record = helmbench.simulate(vessel, **asked)
    record = record.turned(positive_rudder) if positive_rudder else record
    helmbench.write_record(record, output)
    facts = {"record": str(output), "vessel": vessel, "samples": record.n, "dt_s": record.dt}
    more = {"channels": list(record.channels), "positive_rudder": record.meta.positive_rudder}
    told = f"{output}: {record.n} samples every {record.dt:g} s, {', '.join(record.channels)}"
    printer.show(lambda: facts | more, lambda: told)


# ---- `helmbench export MODEL --to FORMAT -o DIR`.


@command(output=Output("Folder of the files.", "export", "a folder"))
@click.argument("model", type=MODEL)
@click.option("--to", required=True, type=FORMATS, help="What the files are for.")
def export(model: str, to: str, output: Path, force: bool, printer: Printer) -> None:
    """Write a model as files that another program reads.

    MODEL is a vessel id or a model.json.  Each file says its frame, its signs, and what of the model it cannot hold.
    """
    import helmbench

    paths = helmbench.export_model(model, to, output, force=force)
    printer.show(lambda: {"model": model, "to": to, "files": [str(path) for path in paths]}, files=paths)


# ---- `helmbench import-model TABLE --family FAMILY --positive-rudder SIDE -o model.json`.

IMPORT_MODEL_OPTIONS = "family positive_rudder speed_m_s n0_rps"
MODEL_FILE = Output("model.json to write.", writes="a file")


@command("read_parameters", IMPORT_MODEL_OPTIONS, MODEL_FILE._replace(default="model.json"), name="import-model")
@click.argument("table", type=FILE)
def import_model(table: Path, output: Path, printer: Printer, **asked: Any) -> None:
    """Make a model from a published table of parameters.

    TABLE is CSV, YAML or JSON of names, values and units.
    """
    import helmbench
    from helmbench.models.model import model_to_json

    model = helmbench.read_parameters(table, **asked)
    model_to_json(model, output)
    printer.show(lambda: {"table": str(table), "family": asked["family"], "output": str(output)}, files=[output])


# ---- `helmbench from-indices SHIP.yaml -o model.json`.


@command(output=MODEL_FILE, name="from-indices")
@click.argument("indices", metavar="SHIP.yaml", type=FILE)
def from_indices(indices: Path, output: Path | None, printer: Printer) -> None:
    """Make a model from a wheelhouse poster or sea trial.

    SHIP.yaml holds length, approach speed, and indices of turning circles and zigzags (docs/how-to/from-indices.md).
    Prints every parameter with its interval, or that it is not determined, and the indices given and of the model.
    """
    import helmbench

    with fit_told(str(indices)):
        found = helmbench.model_from_indices(indices)
    if output is not None:
        found.save(output)
    files = [output] if output is not None else []
    printer.show(lambda: found.to_json() | {"output": str(output) if files else None}, found.summary, files)
