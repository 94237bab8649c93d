"""`helmbench run --suite NAME -o DIR`."""

from __future__ import annotations

import shlex
import sys
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from ._from_api import ApiCommand, several
from ._shared import (
    FAILED,
    FILE,
    METHOD,
    NUMBER,
    OK,
    SUITE,
    VESSEL,
    Printer,
    WholeRange,
    confirmed,
    echo,
    output_options,
    print_json,
    tuning_options,
)

if TYPE_CHECKING:
    from .. import SuiteResults

OPTIONS = {
    "suite": SUITE,
    "methods": several(METHOD, "--method"),
    "vessels": several(VESSEL, "--vessel"),
    "seeds": WholeRange(1, 1_000_000),
    "seed": WholeRange(min=0),
    "jobs": WholeRange(min=1),
    "scheduler": click.STRING,
    "array": click.Choice(["slurm", "local"]),
    "reuse": several(FILE),
    "timeout_s": NUMBER,
    "memory_gib": NUMBER,
    "resume": click.BOOL,
}


@click.command(cls=ApiCommand, api="run_suite", options=OPTIONS)
@click.option(
    "--array-option", "array_options", multiple=True, help="Option of the jobs, e.g. timeout_min=240 (repeatable)."
)
@tuning_options
@click.option("--trust", is_flag=True, help="Run code that the suite file, or the directory to resume, names.")
@click.option("-o", "--output", type=FILE, help="directory of the results  [default: out/SUITE]")
@output_options
def run(
    array_options: tuple[str, ...],
    tuner: str | None,
    storage: str | None,
    trust: bool,
    output: Path | None,
    printer: Printer,
    **asked: Any,
) -> int:
    """Run a suite; every finished run is stored at once."""
    from .. import run_suite, with_tuner
    from ..api.suites import QUICK

    asked["methods"] = with_tuner(asked["methods"], tuner, storage)
    found = run_suite(
        **asked,
        directory=output or Path("out", Path(asked["suite"] or QUICK).stem),
        array_options=_named(array_options),
        trust=trust or (confirmed if sys.stdin.isatty() and sys.stderr.isatty() else False),
        progress=printer.progress,
        message=None if printer.hidden else lambda text: echo(text, err=True),
    )
    return _summarise(found, printer)


def _named(texts: tuple[str, ...]) -> dict[str, str | int]:
    """Options `name=value`; whole numbers are numbers."""
    pairs = [text.partition("=") for text in texts]
    wrong = next((text for text, (name, equal, _) in zip(texts, pairs, strict=True) if not (name and equal)), None)
    if wrong is not None:
        raise click.BadParameter(f"{wrong!r} is not name=value", param_hint="--array-option")
    return {name: int(value) if value.isascii() and value.isdigit() else value for name, _, value in pairs}


def _summarise(found: SuiteResults, printer: Printer) -> int:
    """Say how the runs ended; status 1 if some failed."""
    counts = found.counts
    if printer.as_json:
        seed = found.manifest["selection"].get("seed")
        drawn = {} if seed is None else {"seed": seed}
        where = {"directory": str(found.directory), "suite": found.suite}
        print_json({**where, **drawn, "runs": len(found.rows), **counts, "failures": found.failures})
    else:
        for told, number in found.failure_texts.items():
            echo(f"failed: {told}" + (f" ({number} runs)" if number > 1 else ""), err=True)
        if not printer.quiet:
            told = f"{counts['ok']} ok, {counts['failed']} failed, {counts['not_applicable']} not applicable"
            echo(f"suite {found.suite}: {len(found.rows)} runs, {told}; results in {found.directory}")
            echo(f"next: helmbench report {shlex.quote(str(found.directory))}")
    return FAILED if counts["failed"] else OK
