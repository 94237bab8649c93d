"""`helmbench exam make|answer|score`."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import click

from ._from_api import ApiCommand, several
from ._shared import (
    FAILED,
    FILE,
    OK,
    SUITE,
    VESSEL,
    CommandGroup,
    Identifier,
    Printer,
    WholeRange,
    check_folder,
    echo,
    force_option,
    output_options,
    print_json,
    show_files,
)

EXAM = click.argument("folder", metavar="EXAM", type=FILE)


@click.group(cls=CommandGroup)
def exam() -> None:
    """Make, answer and score exams for diagnosis methods.

    An exam is a set of worlds with hidden changes; methods of any kind may answer it.
    """


@exam.command(
    "make",
    cls=ApiCommand,
    api="make_exam",
    options={
        "key": FILE,
        "worlds": WholeRange(1, 500),
        "seed": WholeRange(0, 10**18),
        "suite": SUITE,
        "vessels": several(VESSEL, "--vessel"),
    },
)
@EXAM
@output_options
def make(folder: Path, printer: Printer, **asked: Any) -> None:
    """Draw the worlds of an exam into the new folder EXAM, and its answers into the key."""
    from .. import make_exam

    key, worlds = asked["key"], asked["worlds"]
    found = make_exam(folder, **asked, progress=printer.progress)
    told = f"exam {found}: {worlds} worlds in {folder}; its README.md says what to hand in; keep {key} to yourself"
    printer.show(lambda: {"exam": found, "folder": str(folder), "key": str(key), "worlds": worlds}, lambda: told)


@exam.command("answer")
@EXAM
@click.option("--diagnoser", required=True, type=Identifier("diagnosers"), help="Its name, or path.py:Class.")
@click.option("-o", "--output", default="submission", show_default=True, type=FILE, help="directory of the submission")
@output_options
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


@exam.command("score")
@EXAM
@click.argument("submissions", metavar="SUBMISSION...", nargs=-1, required=True, type=FILE)
@click.option("--key", required=True, type=FILE, help="File of the answers.")
@click.option("-o", "--output", type=FILE, help="directory of scores.json, scores.csv and scores.md")
@force_option
@output_options
def score(
    folder: Path,
    submissions: tuple[Path, ...],
    key: Path,
    output: Path | None,
    force: bool,
    printer: Printer,
) -> None:
    """Score submissions: naming, sizes, regimes and held-out motion, by kind of world and over all."""
    from .. import score_exam
    from ..api.exam import FILES

    if output is not None:
        check_folder(output, FILES, force)
    found = score_exam(folder, submissions, key)
    paths = found.write(output) if output is not None else ()
    printer.show(found.to_json, found.summary, markdown=True)
    if not printer.quiet:
        show_files(paths)
