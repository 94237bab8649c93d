"""`helmbench export MODEL --to FORMAT -o DIR`."""

from __future__ import annotations

from pathlib import Path

import click

from ._shared import FILE, FORMATS, MODEL, Printer, check_folder, force_option, output_options


@click.command("export")
@click.argument("model", type=MODEL)
@click.option("--to", required=True, type=FORMATS, help="What the files are for.")
@click.option("-o", "--output", default="export", show_default=True, type=FILE, help="Folder of the files.")
@force_option
@output_options
def export(model: str, to: str, output: Path, force: bool, printer: Printer) -> None:
    """Write a model as files that another program reads.

    MODEL is a vessel id or a model.json.  Each file says its frame, its signs, and what of the model it cannot hold.
    """
    import helmbench

    check_folder(output, (), force)
    paths = helmbench.export_model(model, to, output, force=force)
    printer.show(lambda: {"model": model, "to": to, "files": [str(path) for path in paths]}, files=paths)
