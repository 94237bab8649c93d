"""One call of `helmbench reproduce`: compute, summarise, draw and write."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

from ..bench.pool import Pool
from ..models.errors import BadInput
from ..models.folders import make_folder
from . import results, runner
from .claims import files
from .claims.claim import DERIVED, Paper
from .pages import html, markdown
from .results import Results
from .runner import Run
from .verdicts import Spread

PAGES, INTERACTIVE = "pages", "interactive"


def select(paper: str | None, table: int | None) -> list[Paper]:
    """The papers, or one of them, or one table of it; raises `BadInput` where there is no such."""
    if table is not None and paper is None:
        raise BadInput("--table needs a paper", hint=f"name one of {', '.join(files.papers())}")
    chosen = [files.load(name) for name in (files.everything() if paper is None else [paper])]
    return chosen if table is None else [found.only_table(table) for found in chosen]


def reproduce(
    chosen: Sequence[Paper],
    directory: Path,
    pool: Pool,
    resume: bool = False,
    watch: Callable[[Run | None], object] = lambda run: None,
    seed: int = 0,
) -> list[tuple[Paper, Results]]:
    """Compute the runs that the directory lacks.  Its folder `pages` gets results, figures and Markdown pages, its
    folder `interactive` HTML pages with search and zoom.  Another `seed` draws other random numbers throughout.

    Raises `BadInput` if the directory has other contents, or another process computes there.
    """
    jobs = runner.plan(chosen, seed)
    with runner.open_store(directory, resume, len(jobs), seed) as store:
        for folder in (directory / PAGES, directory / INTERACTIVE):
            make_folder(folder, within=directory)
        runs = runner.compute(jobs, store, pool, watch)
        found = [(paper, _drawn(paper, results.of_runs(paper, runs), runs, directory / PAGES)) for paper in chosen]
        for _, one in found:
            results.write(one, directory / PAGES)
        markdown.write(chosen, directory / PAGES)
        told = [(paper, one) for paper, one in found if paper.claims]
        html.write(told, directory / PAGES, directory / INTERACTIVE)
    return found


def rows(found: Sequence[tuple[Paper, Results]]) -> list[dict[str, Any]]:
    """Every claim as plain values: published, ours as {median, low, high}, verdict and reason."""
    return [
        {
            "paper": paper.paper,
            "item": judged.claim.item,
            "kind": judged.claim.kind,
            "quantity": judged.claim.quantity,
            "unit": judged.claim.unit,
            "published": None if judged.claim.kind == DERIVED else judged.claim.published,
            "from_printed_numbers": judged.claim.published if judged.claim.kind == DERIVED else None,
            "corrected": _plain(judged.corrected),
            "as_printed": _plain(judged.as_printed),
            "verdict": judged.verdict,
            "reason": judged.reason,
            "equation": judged.claim.equation or None,
        }
        for paper, one in found
        for judged in one.judged(paper)
    ]


def _drawn(paper: Paper, found: Results, runs: Sequence[Run], directory: Path) -> Results:
    """The results with the digests of the figures, which are drawn where their study has runs."""
    digests = {}
    for figure in paper.figures:
        own = [run for run in runs if runner.is_of(run, paper.paper, figure.study) and not run["row"]["error"]]
        if own:
            digests[figure.id] = markdown.write_figure(paper, figure, [runner.result_of(run) for run in own], directory)
    return dataclasses.replace(found, figures=digests)


def _plain(found: Spread) -> dict[str, float] | None:
    return {"median": found.median, "low": found.low, "high": found.high} if found.known else None
