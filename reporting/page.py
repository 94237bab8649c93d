"""The page of a result: what it says, in the order of a reader's questions, apart from how a medium shows it.

A result gives a `Page` of blocks; `media` has one renderer for each medium: terminal, notebook, HTML, Markdown.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass
from functools import cache
from typing import TYPE_CHECKING

from .tables import Table

if TYPE_CHECKING:
    from ..models.model import Model
    from .equation_lines import EquationLine
    from .equations import Equations
    from .runs import RecordRuns

GOOD, FAIR, BAD = "good", "fair", "bad"
QUESTIONS = ("Measured and simulated", "What changed", "What remains", "What to sail next")
"""Titles of the parts that stand open."""
OVERVIEW = 3
"""Records that the first figure shows."""


@dataclass(frozen=True)
class Verdict:
    """The first sentence with what supports it, the verdict in a word, and how a page sets it off (GOOD, FAIR, BAD)."""

    tone: str
    sentence: str
    told: tuple[str, ...] = ()
    label: str = ""


@dataclass(frozen=True)
class Note:
    """How to read what stands above; a terminal leaves it out."""

    text: str


@dataclass(frozen=True)
class Items:
    """A list; each row is a text, or a title with the texts that belong to it."""

    rows: tuple[tuple[str, ...], ...]


@dataclass(frozen=True)
class Drawing:
    """A figure of statistics: name of its file, caption, what draws it as an SVG file (empty: nothing to draw)."""

    name: str
    caption: str
    draw: Callable[[], str]


@dataclass(frozen=True)
class Overlays:
    """Measured channels and runs of records: all in one figure, or each with its errors and its track."""

    records: tuple[RecordRuns, ...]
    together: bool = False


@dataclass(frozen=True)
class EquationList:
    """Equations; what makes them loads SymPy."""

    lines: Callable[[], Sequence[EquationLine]]


@dataclass(frozen=True)
class Section:
    """Blocks below a title; folded away on a page, and left out of terminal and notebook, where `folded`."""

    title: str
    blocks: tuple[Block, ...]
    folded: bool = False


Block = str | Note | Table | Items | Drawing | Overlays | EquationList | Section
Blocks = Sequence["Block | None"]


@dataclass(frozen=True)
class Page:
    """A page: title, what it is about, doubts about the records, verdict, and parts in their order."""

    title: str
    about: str
    verdict: Verdict
    doubts: tuple[str, ...]
    parts: tuple[Section, ...]

    def blocks(self) -> Iterator[Block]:
        """Every block, those of parts within parts included."""
        pending: list[Block] = list(self.parts)
        while pending:
            block = pending.pop(0)
            yield block
            if isinstance(block, Section):
                pending[:0] = block.blocks

    def records(self) -> tuple[RecordRuns, ...]:
        """All records of which the first figure shows some."""
        found = [block for block in self.blocks() if isinstance(block, Overlays)]
        shown = next((block.records[0] for block in found if block.together), None)
        every = (block.records for block in found if not block.together)
        return next((records for records in every if any(one is shown for one in records)), ())


def result_page(
    title: str,
    about: str,
    verdict: Verdict,
    *,
    seen: Blocks = (),
    changed: Blocks = (),
    remains: Blocks = (),
    following: Blocks = (),
    details: Sequence[Section] = (),
    doubts: Sequence[str] = (),
    titles: tuple[str, str, str, str] = QUESTIONS,
) -> Page:
    """The page of a result: the sentence, what was measured and simulated, what changed, what remains, what to sail
    next, and folded below it all else.

    titles : of the four parts that stand open.  Blocks that say nothing, and parts without any, are left out.
    """
    answers = zip(titles, (seen, changed, remains, following), strict=True)
    parts = [section(name, blocks) for name, blocks in answers]
    parts += [section(one.title, one.blocks, folded=True) for one in details]
    return Page(title, about, verdict, tuple(doubts), tuple(one for one in parts if one.blocks))


def section(title: str, blocks: Blocks, folded: bool = False) -> Section:
    """The part with the blocks that say something; without any where they are notes alone."""
    kept = tuple(block for block in blocks if block is not None and _says_something(block))
    return Section(title, kept if any(not isinstance(one, Note) for one in kept) else (), folded)


def _says_something(block: Block) -> bool:
    if isinstance(block, Section):
        return any(map(_says_something, block.blocks))
    if isinstance(block, Table | Items):
        return bool(block.rows)
    return bool(block.records) if isinstance(block, Overlays) else bool(block)


def items(texts: Sequence[str | tuple[str, ...]]) -> Items:
    """A list of texts, or of titles with what belongs to them."""
    return Items(tuple((text,) if isinstance(text, str) else text for text in texts))


def pairs(rows: Iterable[tuple[str, str]]) -> Items:
    """A list of names with a text each."""
    return items([f"{name}: {text}" for name, text in rows])


def overlays(records: Sequence[RecordRuns]) -> tuple[Overlays, Section]:
    """The first figure, of held-out records where there are some, and the part with every record by itself."""
    held_out = [one for one in records if one.role != "train"] or list(records)
    return Overlays(tuple(held_out[:OVERVIEW]), together=True), Section(
        "Every record, with errors", (Overlays(tuple(records)),)
    )


def sides(records: Sequence[tuple[str, str]]) -> str:
    """`3 training and 1 held-out records`."""
    train = sum(role == "train" for _, role in records)
    return f"{train} training and {len(records) - train} held-out records"


def equation_parts(model: Model, base: Model) -> tuple[EquationList, Section]:
    """The equations of a model that `base` has not, with the values of new numbers, and the part with all of them."""

    @cache
    def made() -> Equations:
        from .equations import equations

        return equations(model, base)

    def new() -> list[EquationLine]:
        return [line for line in (*made().relations, *made().dynamics) if line.new] + list(made().added)

    def every() -> list[EquationLine]:
        from .equation_lines import statement

        between = [statement("with", new=False)] if made().helpers else []
        return [*made().relations, *made().dynamics, *between, *made().helpers]

    note = Note("New terms are marked; terms with a coefficient of zero are left out.")
    return EquationList(new), Section("All equations of the model", (EquationList(every), note))
