"""What an import did: the columns, the steps, and all faults of the files."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from collections.abc import Mapping as Dict
from dataclasses import dataclass
from typing import TYPE_CHECKING

from ...models.errors import BadInput
from .draft import DraftColumn, Sure
from .finding import LEVELS

if TYPE_CHECKING:
    from .draft import Question
    from .mapping import Mapping

MOST_TOLD = 4
"""Faults that the one line of an error repeats."""


@dataclass(frozen=True)
class FileFault:
    """Something wrong with a file: where, what, what to do, and whether the import ends by it."""

    table: str
    message: str
    hint: str = ""
    row: int | None = None
    column: str | None = None
    fatal: bool = False

    def __str__(self) -> str:
        return str(BadInput(self.message, file=self.table, row=self.row, column=self.column, hint=self.hint or None))


@dataclass(frozen=True)
class ImportReport:
    """Columns, steps in their order, faults that did not end the import, and what the channels are made of."""

    columns: tuple[DraftColumn, ...]
    steps: tuple[str, ...]
    faults: tuple[FileFault, ...]
    channels: tuple[ChannelSource, ...] = ()


class ImportFault(BadInput):
    """A log cannot be imported; `columns` and `faults` hold all that is known and all that is wrong, `questions` what
    is asked, `draft` a mapping with '?' where something is open (None where there is none)."""

    def __init__(
        self,
        faults: Sequence[FileFault],
        columns: Sequence[DraftColumn] = (),
        draft: Mapping | None = None,
        questions: Sequence[Question] = (),
    ) -> None:
        fatal = [*(_as_fault(question) for question in questions), *(fault for fault in faults if fault.fatal)]
        self.faults, self.columns, self.draft = tuple(faults), tuple(columns), draft
        self.questions = tuple(questions)
        if len(fatal) == 1:
            f = fatal[0]
            super().__init__(f.message, file=f.table, row=f.row, column=f.column, hint=f.hint or None)
            return
        told = "; ".join(f"({i}) {fault}" for i, fault in enumerate(fatal[:MOST_TOLD], start=1))
        more = f"; and {len(fatal) - MOST_TOLD} more" if len(fatal) > MOST_TOLD else ""
        what = "questions" if len(questions) == len(fatal) else "faults"
        super().__init__(f"{len(fatal)} {what}: {told}{more}")

    def __reduce__(self):
        return ImportFault, (self.faults, self.columns, self.draft, self.questions)


def _as_fault(question: Question) -> FileFault:
    lines = " or ".join(answer.line for answer in question.answers[:3]) or question.number
    return FileFault(
        question.table, question.text, f"put into the map: {lines}", column=question.column or None, fatal=True
    )


def refuse_fatal(
    faults: Iterable[FileFault],
    columns: Sequence[DraftColumn] = (),
    draft: Mapping | None = None,
    questions: Sequence[Question] = (),
) -> None:
    """Raise ImportFault, with all faults and questions, if a fault is fatal or something is asked."""
    found = list(faults)
    if questions or any(fault.fatal for fault in found):
        raise ImportFault(found, columns, draft, questions)


# ---- Of every channel of a record: from which columns it is, and whether they are stated, told or assumed.

TOLD: dict[Sure, str] = {
    "stated": "stated", "other channel": "told by another channel", "physics": "told by physics", "guess": "assumed",
}  # fmt: skip
"""How surely a column is known, in words."""


@dataclass(frozen=True)
class ChannelSource:
    """A channel of a record, the columns that it is made of, and how surely: the least sure of them."""

    record: str
    channel: str
    columns: tuple[str, ...]
    sure: str
    why: str


def channel_sources(
    record: str, channels: Sequence[str], sources: Dict[str, Sequence[str]], columns: Sequence[DraftColumn]
) -> list[ChannelSource]:
    """The sources of the channels of a record.

    sources : channel -> quantities that it is made of.  columns : of the tables of the record.
    """
    out = []
    for channel in channels:
        own = [c for c in columns if c.quantity in sources.get(channel, ())]
        least = max((c.sure for c in own), key=LEVELS.index, default="guess")
        why = "; ".join(dict.fromkeys(f"{c.column}: {c.why}" for c in own))
        out.append(ChannelSource(record, channel, tuple(c.column for c in own), TOLD[least], why))
    return out
