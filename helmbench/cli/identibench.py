"""`helmbench identibench export|import`."""

from __future__ import annotations

import shlex
from pathlib import Path

import click

from ._shared import FILE, SUITE, VESSEL, Group, WholeRange, echo, output_options, print_json


@click.group(cls=Group)
def identibench() -> None:
    """Exchange suites and data with identibench."""


@identibench.command("export")
@click.argument("suite", type=SUITE)
@click.option("--vessel", "vessels", multiple=True, type=VESSEL, help="Only these vessels (repeatable).")
@click.option("--seeds", type=WholeRange(1, 1_000_000), help="Number of seeds; default: the suite's.")
@click.option("-o", "--output", default="problems", show_default=True, type=FILE, help="directory of the problems")
@output_options
def export(suite: str, vessels: tuple[str, ...], seeds: int | None, output: Path, as_json: bool, quiet: bool) -> None:
    """Write the problems of an identification suite as HDF5 files, for identibench or any other program."""
    from .. import export_problems

    names = export_problems(suite, output, vessels=vessels, seeds=seeds)
    if as_json:
        print_json({"directory": str(output), "problems": list(names)})
    elif not quiet:
        echo(f"{len(names)} problems in {output}; its README.md says what they are")


@identibench.command("import")
@click.option("--data-root", type=FILE, help="identibench's data; default: IDENTIBENCH_DATA_ROOT, ~/.identibench_data.")
@click.option(
    "-o",
    "--output",
    default="identibench-records",
    show_default=True,
    type=FILE,
    help="folder of records and suite.yaml",
)
@output_options
def suite(data_root: Path | None, output: Path, as_json: bool, quiet: bool) -> None:
    """Write identibench's ship set as records, with a suite of every method on them."""
    from .. import identibench_suite

    path = identibench_suite(output, data_root)
    if as_json:
        print_json({"suite": str(path)})
    elif not quiet:
        echo(f"records in {output}; next: helmbench run --suite {shlex.quote(str(path))} -o results")
