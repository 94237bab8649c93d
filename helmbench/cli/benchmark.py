"""Commands of the benchmark: run, report, compare, merge, advice, exam, reproduce, identibench, fetch."""

from __future__ import annotations

import shlex
import sys
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from ._from_api import Output, command
from ._shared import (
    FAILED,
    FILE,
    OK,
    RESULTS,
    SUITE,
    CommandGroup,
    Identifier,
    Printer,
    WholeRange,
    check_folder,
    confirmed,
    echo,
    print_json,
    show_files,
    tuning_options,
)

if TYPE_CHECKING:
    from .. import SuiteResults


# ---- `helmbench run --suite NAME -o DIR`.


RUN_OPTIONS = "suite methods vessels seeds seed jobs scheduler reuse timeout_s memory_gib resume"


@command("run_suite", RUN_OPTIONS, Output(f"{RESULTS}  [default: out/SUITE]"))
@tuning_options
@click.option("--trust", is_flag=True, help="Run code that the suite file, or the directory to resume, names.")
def run(
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
        trust=trust or (confirmed if sys.stdin.isatty() and sys.stderr.isatty() else False),
        progress=printer.progress,
        message=None if printer.hidden else lambda text: echo(text, err=True),
    )
    return _summarise(found, printer)


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


# ---- `helmbench report DIR`.


@command("write_report", "csv")
@click.argument("directory", metavar="DIR", type=FILE)
def report(directory: Path, printer: Printer, **asked: Any) -> None:
    """Write the report of stored results.

    Markdown, CSV and HTML; nothing is fitted again.
    """
    from .. import write_report

    written = write_report(directory, **asked)
    printer.show(written.as_dict, lambda: written.overview, written.paths)


# ---- `helmbench compare A B`.


@command()
@click.argument("first", metavar="A", type=FILE)
@click.argument("second", metavar="B", type=FILE)
def compare(first: Path, second: Path, printer: Printer) -> None:
    """Say what changed between two result directories.

    Runs are paired; every change has an interval.
    """
    from .. import compare_results

    found = compare_results(first, second)
    printer.show(found.to_json, found.summary)


# ---- `helmbench merge SOURCE TARGET`.


@command("merge_results", "sample seed")
@click.argument("source", metavar="SOURCE", type=FILE)
@click.argument("target", metavar="TARGET", type=FILE)
@click.option("--trust", is_flag=True, help="Run code that the directories name.")
def merge(source: Path, target: Path, trust: bool, printer: Printer, **asked: Any) -> None:
    """Check results from elsewhere and add them to TARGET."""
    from .. import merge_results

    asks = confirmed if sys.stdin.isatty() and sys.stderr.isatty() else False
    found = merge_results(source, target, **asked, trust=trust or asks)
    known = f"{found.known} were there already, {found.recomputed} were computed again and agree"
    told = [f"{found.added} runs added; {known}; sample of seed {found.seed} (--seed {found.seed} draws it again)"]
    told += [f"not verified: {why}" for why in found.not_computable]
    printer.show(lambda: vars(found), lambda: "\n".join([*told, f"next: helmbench report {target}"]))


# ---- `helmbench advice BOARD -o DIR`.


ADVICE_RUNS = Output("directory of the runs and the page; goes on where it stopped", "advice-results")


@command("check_advice", "situations seed methods jobs timeout_s", ADVICE_RUNS)
@click.argument("board", type=FILE)
def advice(board: Path, output: Path, printer: Printer, **asked: Any) -> None:
    """Test a leaderboard's advice in fresh situations.

    All methods run; the regret is of what the board names.
    """
    from .. import check_advice

    found = check_advice(board, directory=output, **asked, progress=printer.progress)
    printer.show(found.to_json, found.summary, found.paths)


# ---- `helmbench exam make|answer|score`.

EXAM = click.argument("folder", metavar="EXAM", type=FILE)


@click.group(cls=CommandGroup)
def exam() -> None:
    """Make, answer and score exams for diagnosis methods.

    An exam is a set of worlds with hidden changes; methods of any kind may answer it.
    """


@command("make_exam", "key worlds seed suite vessels", seed=WholeRange(0, 10**18))
@EXAM
def make(folder: Path, printer: Printer, **asked: Any) -> None:
    """Draw the worlds of an exam into the new folder EXAM, and its answers into the key."""
    from .. import make_exam

    key, worlds = asked["key"], asked["worlds"]
    found = make_exam(folder, **asked, progress=printer.progress)
    told = f"exam {found}: {worlds} worlds in {folder}; its README.md says what to hand in; keep {key} to yourself"
    printer.show(lambda: {"exam": found, "folder": str(folder), "key": str(key), "worlds": worlds}, lambda: told)


@command(output=Output("directory of the submission", "submission"))
@EXAM
@click.option("--diagnoser", required=True, type=Identifier("diagnosers"), help="Its name, or path.py:Class.")
def answer(folder: Path, diagnoser: str, output: Path, printer: Printer) -> int:
    """Answer an exam with a diagnoser of helmbench; writes submission.json and the predicted motion."""
    from .. import answer_exam

    check_folder(output)
    failed = answer_exam(folder, diagnoser, output, progress=printer.progress)
    if printer.as_json:
        print_json({"failed": failed})
    else:
        for world, reason in failed.items():
            echo(f"{world}: {reason}", err=True)
    if not printer.quiet:
        show_files([output / "submission.json"])
    return FAILED if failed else OK


@command(output=Output("directory of scores.json, scores.csv and scores.md", writes="ExamScores"))
@EXAM
@click.argument("submissions", metavar="SUBMISSION...", nargs=-1, required=True, type=FILE)
@click.option("--key", required=True, type=FILE, help="File of the answers.")
def score(folder: Path, submissions: tuple[Path, ...], key: Path, output: Path | None, printer: Printer) -> None:
    """Score submissions: naming, sizes, regimes and held-out motion, by kind of world and over all."""
    from .. import score_exam

    found = score_exam(folder, submissions, key)
    paths = found.write(output) if output is not None else ()
    printer.show(found.to_json, found.summary)
    if not printer.quiet:
        show_files(paths)


for own in (make, answer, score):
    exam.add_command(own)


# ---- `helmbench reproduce [PAPER] [--table N]`.


@command("reproduce", "table jobs seed resume directory")
@click.argument("paper", required=False, metavar="[PAPER]")
def reproduce(paper: str | None, printer: Printer, **asked: Any) -> int:
    """Compute the tables of the five papers again.

    Tables and claims are compared with the printed ones; PAPER: 003 for one paper.
    """
    import helmbench

    found = helmbench.reproduce(paper, **asked, progress=printer.progress)
    for failure in found.failures:
        echo(f"failed: {failure}", err=True)
    told = [f"{row['paper']} {row['item']}, {row['quantity']}: {row['verdict']}. {row['reason']}" for row in found.rows]
    told += [f"paper {paper}: {counts}" for paper, counts in found.counts.items()]
    printer.show(lambda: found.rows, lambda: "\n".join(told))
    return FAILED if found.failures else OK


# ---- `helmbench identibench export|import`.


@click.group(cls=CommandGroup)
def identibench() -> None:
    """Exchange suites and data with identibench."""


@command("export_problems", "vessels seeds", Output("directory of the problems", "problems"))
@click.argument("suite", type=SUITE)
def export(suite: str, output: Path, printer: Printer, **asked: Any) -> None:
    """Write the problems of an identification suite as HDF5 files, for identibench or any other program."""
    from .. import export_problems

    names = export_problems(suite, output, **asked)
    told = f"{len(names)} problems in {output}; its README.md says what they are"
    printer.show(lambda: {"directory": str(output), "problems": list(names)}, lambda: told)


SHIP_SET = Output("folder of records and suite.yaml", "identibench-records")


@command("identibench_suite", "data_root", SHIP_SET, name="import")
def suite(data_root: Path | None, output: Path, printer: Printer) -> None:
    """Write identibench's ship set as records, with a suite of every method on them."""
    from .. import identibench_suite

    path = identibench_suite(output, data_root)
    told = f"records in {output}; next: helmbench run --suite {shlex.quote(str(path))} -o results"
    printer.show(lambda: {"suite": str(path)}, lambda: told)


for own in (export, suite):
    identibench.add_command(own)


# ---- `helmbench fetch DATASET`.


@command()
@click.argument("dataset")
def fetch(dataset: str, printer: Printer) -> None:
    """Download a measured set into HELMBENCH_DATA, SHA-256 checked."""
    import helmbench

    paths = helmbench.fetch(dataset, progress=printer.progress)
    told = f"{dataset}: {len(paths)} files in {paths[0].parent}"
    printer.show(lambda: {"dataset": dataset, "files": [str(path) for path in paths]}, lambda: told)
