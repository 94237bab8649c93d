"""HTML pages for local use: claims that can be searched and filtered, figures that can be zoomed.

They go into a folder of their own; only the Markdown pages are published.
"""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from ...models.folders import make_folder, write_atomic
from ...reporting.plots import embedded
from ...reporting.templating import render
from ..claims.claim import Paper
from ..results import Results
from ..verdicts import VERDICTS
from .markdown import claim_table, file_of


def write(found: Sequence[tuple[Paper, Results]], pages: Path, directory: Path) -> list[Path]:
    """One self-contained HTML page a paper into `directory`, with the figures that lie in the folder `pages`."""
    written = []
    make_folder(directory, within=directory.parent)
    for paper, results in found:
        path = directory / f"{paper.paper}.html"
        write_atomic(path, page(paper, results, pages).encode())
        written.append(path)
    return written


def page(paper: Paper, results: Results, pages: Path) -> str:
    """The page of one paper as text."""
    drawn = [(figure, pages / file_of(paper.paper, figure)) for figure in paper.figures if figure.id in results.figures]
    figures = [
        {"title": figure.title, "caption": figure.caption, "svg": embedded(path.read_text("utf-8"), figure.title)}
        for figure, path in drawn
    ]
    return render(
        "reproduction.html.j2",
        paper=paper.paper,
        title=paper.title,
        citation=paper.citation,
        verdicts=VERDICTS,
        claims=claim_table(results.judged(paper)),
        figures=figures,
    )
