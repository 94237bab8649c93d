"""`helmbench report DIR`."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import click

from ._from_api import ApiCommand
from ._shared import FILE, output_options, print_json, show_files, show_text


@click.command(cls=ApiCommand, api="write_report", options={"timing": FILE, "csv": click.BOOL})
@click.argument("directory", metavar="DIR", type=FILE)
@output_options
def report(directory: Path, as_json: bool, quiet: bool, **asked: Any) -> None:
    """Write the report of stored results.

    Markdown, CSV and HTML; nothing is fitted again.
    """
    from .. import write_report

    written = write_report(directory, **asked)
    if as_json:
        print_json(written.as_dict())
    elif not quiet:
        show_text(written.overview)
        show_files(written.paths)
