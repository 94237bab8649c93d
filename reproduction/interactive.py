"""Pages to work with on one's own machine: claims that can be searched and filtered, figures that can be zoomed.

They are written beside the Markdown pages, not among them: only those are published.
"""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from ..bench.store import write_atomic
from .claims import Paper
from .figures import file_of
from .pages import titles_and_rows
from .results import Results
from .verdict import VERDICTS


def write(found: Sequence[tuple[Paper, Results]], pages: Path, directory: Path) -> list[Path]:
    """One self-contained HTML page a paper into `directory`, with the figures that lie in the folder `pages`."""
    written = []
    for paper, results in found:
        path = directory / f"{paper.paper}.html"
        path.parent.mkdir(parents=True, exist_ok=True)
        write_atomic(path, page(paper, results, pages).encode())
        written.append(path)
    return written


def page(paper: Paper, results: Results, pages: Path) -> str:
    """The page of one paper as text."""
    from jinja2 import Environment, FileSystemLoader, StrictUndefined
    from markupsafe import Markup

    loader = FileSystemLoader(Path(__file__).parents[1] / "reporting" / "templates")
    template = Environment(loader=loader, autoescape=True, undefined=StrictUndefined).get_template(
        "reproduction.html.j2"
    )
    columns, rows = titles_and_rows(results.judged(paper))
    figures = [
        {"title": f.title, "caption": f.caption, "svg": Markup(_svg(pages / file_of(paper.paper, f)))}
        for f in paper.figures
        if f.id in results.figures
    ]
    return template.render(
        paper=paper.paper, title=paper.title, citation=paper.citation, verdicts=VERDICTS,
        columns=columns, rows=rows, figures=figures,
    )  # fmt: skip


def _svg(path: Path) -> str:
    """The drawing itself, without the XML prologue."""
    text = path.read_text("utf-8")
    return text[text.index("<svg") :]
