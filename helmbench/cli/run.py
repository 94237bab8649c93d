"""`helmbench run --suite NAME -o DIR`."""

from __future__ import annotations

import shlex
import sys
from pathlib import Path
from typing import TYPE_CHECKING

import click

from ._shared import (
    FAILED,
    FILE,
    METHOD,
    NUMBER,
    OK,
    SUITE,
    VESSEL,
    WholeRange,
    confirmed,
    echo,
    output_options,
    print_json,
    shows_progress,
    tuning_options,
)

if TYPE_CHECKING:
    from .. import SuiteResults


@click.command()
@click.option(
    "--suite", "suite", type=SUITE, help="quick, default, measured, diagnosis, or a suite file.  [default: quick]"
)
@click.option(
    "--method", "methods", multiple=True, type=METHOD, help="Only these methods (repeatable); also path.py:Class."
)
@click.option("--vessel", "vessels", multiple=True, type=VESSEL, help="Only these vessels (repeatable).")
@click.option("--seeds", type=WholeRange(1, 1_000_000), help="Number of seeds or rounds; default: the suite's.")
@click.option("--seed", type=WholeRange(min=0), help="Seed of the cases of a diagnosis suite; default: a new one.")
@click.option(
    "--jobs", type=WholeRange(min=1), help="Worker processes, at most one a processor; or jobs of an --array."
)
@click.option("--scheduler", help="Run on a dask cluster, tcp://host:port.")
@click.option("--array", type=click.Choice(["slurm", "local"]), help="Run as a job array through submitit.")
@click.option(
    "--array-option", "array_options", multiple=True, help="Option of the jobs, e.g. timeout_min=240 (repeatable)."
)
@click.option("--reuse", multiple=True, type=FILE, help="Take equal runs from this directory of results (repeatable).")
@click.option("--timeout", type=NUMBER, help="Seconds until a run is ended and stored as failed; not with --scheduler.")
@click.option("--memory", type=NUMBER, help="GiB of memory that a run may allocate (Linux); not with --scheduler.")
@tuning_options
@click.option("--resume", is_flag=True, help="Continue a run that was interrupted.")
@click.option("--trust", is_flag=True, help="Run code that the suite file, or the directory to resume, names.")
@click.option("-o", "--output", type=FILE, help="directory of the results  [default: out/SUITE]")
@output_options
def run(
    suite: str | None,
    methods: tuple[str, ...],
    vessels: tuple[str, ...],
    seeds: int | None,
    seed: int | None,
    jobs: int | None,
    scheduler: str | None,
    array: str | None,
    array_options: tuple[str, ...],
    reuse: tuple[Path, ...],
    timeout: float | None,
    memory: float | None,
    tuner: str | None,
    storage: str | None,
    resume: bool,
    trust: bool,
    output: Path | None,
    as_json: bool,
    quiet: bool,
) -> int:
    """Run a suite; every finished run is stored at once."""
    from .. import run_suite, with_tuner
    from ..api.suites import QUICK

    hidden = quiet or as_json
    found = run_suite(
        suite,
        directory=output or Path("out", Path(suite or QUICK).stem),
        methods=with_tuner(methods, tuner, storage),
        vessels=vessels,
        seeds=seeds,
        seed=seed,
        jobs=jobs,
        scheduler=scheduler,
        array=array,
        array_options=_named(array_options),
        reuse=reuse,
        timeout_s=timeout,
        memory_gib=memory,
        resume=resume,
        trust=trust or (confirmed if sys.stdin.isatty() and sys.stderr.isatty() else False),
        progress=shows_progress(hidden),
        message=None if hidden else lambda text: echo(text, err=True),
    )
    return _summarise(found, as_json, quiet)


def _named(texts: tuple[str, ...]) -> dict[str, str | int]:
    """Options `name=value`; whole numbers are numbers."""
    pairs = [text.partition("=") for text in texts]
    wrong = next((text for text, (name, equal, _) in zip(texts, pairs, strict=True) if not (name and equal)), None)
    if wrong is not None:
        raise click.BadParameter(f"{wrong!r} is not name=value", param_hint="--array-option")
    return {name: int(value) if value.isascii() and value.isdigit() else value for name, _, value in pairs}


def _summarise(found: SuiteResults, as_json: bool, quiet: bool) -> int:
    """Say how the runs ended; status 1 if some failed."""
    counts = found.counts
    if as_json:
        seed = found.manifest["selection"].get("seed")
        drawn = {} if seed is None else {"seed": seed}
        where = {"directory": str(found.directory), "suite": found.suite}
        print_json({**where, **drawn, "runs": len(found.rows), **counts, "failures": found.failures})
    else:
        for told, number in found.failure_texts.items():
            echo(f"failed: {told}" + (f" ({number} runs)" if number > 1 else ""), err=True)
        if not quiet:
            told = f"{counts['ok']} ok, {counts['failed']} failed, {counts['not_applicable']} not applicable"
            echo(f"suite {found.suite}: {len(found.rows)} runs, {told}; results in {found.directory}")
            echo(f"next: helmbench report {shlex.quote(str(found.directory))}")
    return FAILED if counts["failed"] else OK
