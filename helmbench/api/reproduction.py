"""The tables and claims of the five papers, computed and compared with what they print."""

from __future__ import annotations

import sys
from collections.abc import Mapping
from contextlib import nullcontext
from dataclasses import dataclass
from html import escape
from pathlib import Path
from typing import TYPE_CHECKING, Any

from ..models.argument_types import typed
from ..models.errors import BadInput

if TYPE_CHECKING:
    from os import PathLike

    from ..reproduction.runner import Run


@dataclass(frozen=True, repr=False)
class Reproduction:
    """Published against computed values."""

    rows: tuple[Mapping[str, Any], ...]
    """Every claim: paper, item, kind, quantity, unit, published, from_printed_numbers (of derived claims, instead),
    corrected and as_printed ({median, low, high}), verdict, reason, equation."""
    counts: Mapping[str, str]
    """Paper -> how many claims it has and how they ended, in words."""
    failures: tuple[str, ...]
    """Runs that failed, in words."""

    def __repr__(self) -> str:
        return f"<Reproduction of {len(self.rows)} claims, {len(self.failures)} failed runs>"

    def _repr_html_(self) -> str:
        from ..models.display import html_table

        columns = ("paper", "item", "quantity", "verdict", "reason")
        counts = "".join(f"<li>paper {escape(paper)}: {escape(told)}</li>" for paper, told in self.counts.items())
        return f"<ul>{counts}</ul>" + html_table(columns, [[str(row[name]) for name in columns] for row in self.rows])


@typed
def reproduce(
    paper: str | None = None,
    table: int | None = None,
    *,
    directory: str | PathLike[str] | None = None,
    jobs: int | None = None,
    resume: bool = False,
    seed: int = 0,
    progress: bool = False,
) -> Reproduction:
    """Compute the tables and claims of the five papers and compare them with what the papers print.

    Parameters
    ----------
    paper : number of a paper, such as '003'; None: all five.
    table : only the claims of this table of the paper.
    directory : keep runs, results and pages here; None: nothing is kept.
    jobs : worker processes; None: one for each processor.
    resume : continue what was started in the directory.
    seed : another number draws other random numbers in every computation.
    progress : show a progress bar on standard error.

    Raises
    ------
    BadInput : there is no such paper or table, or the directory cannot be used.
    """
    from tqdm import tqdm

    from ..bench.pool import processes
    from ..models.temporary import temporary_folder
    from ..reproduction import runner, session
    from ..reproduction.pages.markdown import counts_line

    chosen = session.select(paper, table)
    if resume and directory is None:
        raise BadInput("--resume needs the directory that was started", hint="give it with -o")

    def watch(run: Run | None) -> None:
        bar.update()
        failed.extend([run] if run is not None and run["row"]["error"] else [])

    failed: list[Run] = []
    with (
        temporary_folder() if directory is None else nullcontext(directory) as folder,
        processes(jobs) as pool,
        tqdm(total=len(runner.plan(chosen, seed)), unit="run", disable=not progress, file=sys.stderr) as bar,
    ):
        # a temporary folder is locked itself, so that the runs have a folder of their own in it
        place = Path(folder) / "runs" if directory is None else Path(folder)
        found = session.reproduce(chosen, place, pool, resume, watch, seed)
    return Reproduction(
        rows=tuple(session.rows(found)),
        counts={one.paper: counts_line(results.judged(one)) for one, results in found},
        failures=tuple("paper {paper}, {study} {index}: {error}".format_map(run["row"]) for run in failed),
    )
