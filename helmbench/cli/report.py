"""`helmbench report DIR`."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import click

from ._from_api import ApiCommand
from ._shared import FILE, Printer, output_options


@click.command(cls=ApiCommand, api="write_report", options={"timing": FILE, "csv": click.BOOL})
@click.argument("directory", metavar="DIR", type=FILE)
@output_options
def report(directory: Path, printer: Printer, **asked: Any) -> None:
    """Write the report of stored results.

    Markdown, CSV and HTML; nothing is fitted again.
    """
    from .. import write_report

    written = write_report(directory, **asked)
    printer.show(written.as_dict, lambda: written.overview, written.paths, markdown=True)
