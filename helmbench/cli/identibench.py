"""`helmbench identibench export|import`."""

from __future__ import annotations

import shlex
from pathlib import Path
from typing import Any

import click

from ._from_api import ApiCommand, several
from ._shared import FILE, SUITE, VESSEL, CommandGroup, Printer, WholeRange, output_options


@click.group(cls=CommandGroup)
def identibench() -> None:
    """Exchange suites and data with identibench."""


@identibench.command(
    "export",
    cls=ApiCommand,
    api="export_problems",
    options={"vessels": several(VESSEL, "--vessel"), "seeds": WholeRange(1, 1_000_000)},
)
@click.argument("suite", type=SUITE)
@click.option("-o", "--output", default="problems", show_default=True, type=FILE, help="directory of the problems")
@output_options
def export(suite: str, output: Path, printer: Printer, **asked: Any) -> None:
    """Write the problems of an identification suite as HDF5 files, for identibench or any other program."""
    from .. import export_problems

    names = export_problems(suite, output, **asked)
    told = f"{len(names)} problems in {output}; its README.md says what they are"
    printer.show(lambda: {"directory": str(output), "problems": list(names)}, lambda: told)


@identibench.command("import", cls=ApiCommand, api="identibench_suite", options={"data_root": FILE})
@click.option(
    "-o",
    "--output",
    default="identibench-records",
    show_default=True,
    type=FILE,
    help="folder of records and suite.yaml",
)
@output_options
def suite(data_root: Path | None, output: Path, printer: Printer) -> None:
    """Write identibench's ship set as records, with a suite of every method on them."""
    from .. import identibench_suite

    path = identibench_suite(output, data_root)
    told = f"records in {output}; next: helmbench run --suite {shlex.quote(str(path))} -o results"
    printer.show(lambda: {"suite": str(path)}, lambda: told)
