"""One renderer of pages for each medium: HTML, Markdown with figures, terminal, notebook, PDF.

Terminal and notebook show what is not folded away, and no charts; Markdown, which is published, shows statistics and no
series.
"""

from __future__ import annotations

import logging
from collections.abc import Iterable, Iterator, Mapping
from html import escape
from pathlib import Path
from typing import TYPE_CHECKING

from ..models.errors import BadInput
from ..models.extras import extras_told
from . import tables
from .page import Drawing, EquationList, Items, Note, Overlays, Page, Section, section
from .plots import embedded
from .runs import charts_of, error_line, key_of, together
from .tables import Table, in_markdown
from .templating import render

if TYPE_CHECKING:
    from .page import Block


def html(page: Page, sheet: bool = False) -> str:
    """The page as one self-contained HTML document; `sheet`: small enough for one sheet of paper."""
    charts = {"key_of": key_of, "together": together, "charts_of": charts_of, "error_line": error_line}
    kinds = {"kind_of": lambda block: type(block).__name__, "embedded": embedded}
    return render("result.html.j2", page=page, sheet=sheet, first=_first(page), **kinds, **charts)


# ---- text


def terminal(page: Page) -> str:
    """The page as plain text."""
    lines = [f"{page.title}: {_first(page)}", *(f"  {text}" for text in (page.about, *page.verdict.told) if text)]
    lines[1:1] = [f"doubtful: {doubt}" for doubt in page.doubts]
    for own in _open(page):
        lines += ["", own.title, *(f"  {line}" for block in own.blocks for line in _in_terminal(block))]
    return "\n".join(lines)


def _first(page: Page) -> str:
    """The first sentence, with the verdict in a word before it where there is one."""
    word = f"{page.verdict.label.capitalize()}. " if page.verdict.label else ""
    return word + page.verdict.sentence


def _open(page: Page) -> Iterator[Section]:
    """Parts that are not folded, with what a text shows of them."""
    for own in page.parts:
        shown = tuple(block for block in own.blocks if isinstance(block, str | Table | Items))
        if shown and not own.folded:
            yield Section(own.title, shown)


def _in_terminal(block: Block) -> Iterator[str]:
    if isinstance(block, str):
        yield block
    elif isinstance(block, Table):
        yield from [block.title] if block.title else []
        yield from tables.console(block).splitlines()
    elif isinstance(block, Items):
        for title, *texts in block.rows:
            yield title
            yield from (f"  {text}" for text in texts)


def notebook(page: Page) -> str:
    """The page as HTML for the output of a notebook's cell."""
    told = [(text,) for text in (*(f"doubtful: {doubt}" for doubt in page.doubts), *page.verdict.told)]
    return render("notebook.html.j2", page=page, first=_first(page), told=told, parts=list(_open(page)))


# ---- Markdown


def write_markdown(page: Page, folder: str | Path, name: str, title: str, note: str = "") -> tuple[Path, ...]:
    """Write `name`.md and its figures `name`-*.svg into a folder, all of them or none; the paths."""
    from ..models.files import content_writer, replace_together
    from ..models.folders import make_folder

    folder = Path(folder)
    make_folder(folder)
    drawn = {block.name: block.draw() for block in page.blocks() if isinstance(block, Drawing)}
    files = {key: f"{name}-{key}.svg" for key, svg in drawn.items() if svg}
    texts = {f"{name}.md": markdown(page, title, note, files)} | {file: drawn[key] for key, file in files.items()}
    paths = {folder / file: text for file, text in texts.items()}
    replace_together({path: content_writer(text) for path, text in paths.items()})
    for stale in set(folder.glob(f"{name}-*.svg")) - set(paths):
        stale.unlink()
    return tuple(paths)


def markdown(page: Page, title: str, note: str, files: Mapping[str, str]) -> str:
    """The page as Markdown; `files` has the file name of each of its drawings that was drawn."""
    parts = [f"# {title}", note, f"**{in_markdown(_first(page))}**"]
    parts += [_bullets([(text,) for text in (*page.doubts, *page.verdict.told)])]
    parts += [text for own in page.parts for text in _part(own, files)]
    return "\n\n".join(text for text in parts if text) + "\n"


def _part(shown: Section, files: Mapping[str, str]) -> list[str]:
    """The part; equations that are folded away are many, and stand in the model's file."""
    left = [block for block in shown.blocks if not (shown.folded and isinstance(block, EquationList))]
    blocks = [text for block in section(shown.title, left).blocks for text in _in_markdown(block, files) if text]
    if not blocks:
        return []
    if shown.folded:
        return [f"<details><summary>{escape(shown.title)}</summary>", *blocks, "</details>"]
    return [f"## {shown.title}", *blocks]


def _in_markdown(block: Block, files: Mapping[str, str]) -> list[str]:
    if isinstance(block, str):
        return [in_markdown(block)]
    if isinstance(block, Note):
        return [f"*{in_markdown(block.text)}*"]
    if isinstance(block, Table):
        return [in_markdown(block.title), tables.markdown(block), in_markdown(block.note)]
    if isinstance(block, Items):
        return [_bullets(block.rows)]
    if isinstance(block, Drawing):
        return [f"![{block.caption}]({files[block.name]})", f"*{block.caption}.*"] if block.name in files else []
    if isinstance(block, EquationList):
        return [f"$$\n{line.latex}\n$$" for line in block.lines()]
    return [] if isinstance(block, Overlays) else [f"### {block.title}", *_part(block, files)[1:]]


def _bullets(rows: Iterable[tuple[str, ...]]) -> str:
    lines = []
    for title, *texts in rows:
        lines += [f"- **{in_markdown(title)}**" if texts else f"- {in_markdown(title)}"]
        lines += [f"  - {in_markdown(text)}" for text in texts]
    return "\n".join(lines)


# ---- PDF, by WeasyPrint (extra `pdf`).


def pdf(page: str) -> bytes:
    """A self-contained page (HTML) as a PDF file, as it would be printed; nothing is loaded.

    Raises
    ------
    BadInput : WeasyPrint or the libraries of Pango that it draws text with are not installed.
    """
    with extras_told():
        try:
            from weasyprint import HTML
        except OSError:
            raise BadInput(
                "WeasyPrint finds no Pango", hint="apt-get install libpangoft2-1.0-0, or write HTML"
            ) from None
    logging.getLogger("weasyprint").setLevel(logging.ERROR)  # it warns of rules for screens, which it does not apply
    return bytes(HTML(string=page, url_fetcher=_refused).write_pdf() or b"")


def _refused(url: str) -> dict[str, object]:
    raise ValueError(f"a page loads nothing, not {url}")
