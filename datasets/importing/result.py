"""What an import gives: records, their mapping, columns, steps, faults of files, and columns that are kept aside."""

from __future__ import annotations

import csv
from collections.abc import Callable, Iterable, Sequence
from collections.abc import Mapping as Dict
from dataclasses import dataclass
from pathlib import Path
from typing import Any, TypeAlias

from ...models.errors import BadInput
from ...models.files import content_writer, refuse_existing, replace_together
from ...models.result import FilePath, Result, above
from ..io import record_writers
from ..record import Record
from .draft import DraftColumn, Question, Sure, plain
from .finding import LEVELS
from .mapping import Mapping, mapping_text, read_mapping

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
        fatal = [fault for fault in faults if fault.fatal]
        for question in reversed(questions):
            lines = " or ".join(answer.line for answer in question.answers[:3]) or question.number
            hint, column = f"put into the map: {lines}", question.column or None
            fatal.insert(0, FileFault(question.table, question.text, hint, column=column, fatal=True))
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


# ---- The whole, and its files.

Aside: TypeAlias = "dict[str, dict[str, Any]]"
"""Table -> column -> samples (N,) that are no channel, with the record's `time_s` first."""


@dataclass(frozen=True, eq=False, repr=False)
class Import(Result):
    """The outcome of `import_log`.

    records : one record, or one a run, or one a manoeuvre where the log was cut.  mapping : what every column was taken
    for, to be used again.  report : columns with confidence, what was done, and faults that did not end the import.
    aside : table -> column -> samples (N,) of columns that are no channel.
    """

    room = "importing"
    records: tuple[Record, ...]
    mapping: Mapping
    report: ImportReport
    aside: Aside

    @property
    def record(self) -> Record:
        """The record; BadInput where the log holds several."""
        if len(self.records) != 1:
            names = ", ".join(record.name for record in self.records)
            raise BadInput(f"the log holds {len(self.records)} records", hint=f"take one of `records`: {names}")
        return self.records[0]

    def to_dict(self) -> dict[str, object]:
        """Records, columns, steps and faults as plain data for JSON."""
        return {
            "records": [{"name": r.name, "samples": r.n, "channels": list(r.channels)} for r in self.records],
            "columns": plain(self.report.columns),
            "channels": [vars(channel) for channel in self.report.channels],
            "steps": list(self.report.steps),
            "faults": [vars(fault) for fault in self.report.faults],
        }

    def write(self, path: FilePath, *, force: bool = False) -> tuple[Path, ...]:
        """Write the records with their sidecars, the mapping, and the columns that are kept aside: all or none.

        Parameters
        ----------
        path : of the record, .csv or .parquet; several records get their names behind its stem.  Beside it go
            STEM.map.yaml and STEM.aside.csv.
        force : replace files that exist; a mapping that says the same of the columns stays as it is without it.

        Returns
        -------
        The paths of all files written but the sidecars.

        Raises
        ------
        BadInput : a file exists, or cannot be written.
        """
        path = Path(path)
        several = [path.with_name(f"{path.stem}-{record.name}{path.suffix}") for record in self.records]
        places = [path] if len(self.records) == 1 else several
        writers: dict[Path, Callable[[Path], object]] = {}
        for place, record in zip(places, self.records, strict=True):
            writers |= record_writers(record, place)
        place = path.with_name(f"{path.stem}.map.yaml")
        if force or not _says_the_same(place, self.mapping):
            writers[place] = content_writer(mapping_text(self.mapping, self.report.columns))
        for number, table in enumerate(self.aside.values(), start=1):
            name = f"{path.stem}.aside{'' if len(self.aside) == 1 else f'-{number}'}.csv"
            writers[path.with_name(name)] = _aside_writer(table)
        if not force:
            refuse_existing(writers)
        replace_together(writers)
        sidecars = {place.with_suffix(".yaml") for place in places}
        return tuple(place for place in writers if place not in sidecars)

    def write_mapping(self, path: FilePath, *, force: bool = False) -> None:
        """Write the mapping alone, to be changed by hand; BadInput where it exists or cannot be written."""
        write_mapping(self.mapping, path, force, self.report.columns)

    def __repr__(self) -> str:
        return f"<Import of {', '.join(record.name for record in self.records)}>"

    def _repr_html_(self) -> str:
        from ...models.figure import picture

        drawn = "".join(picture(record.plot, f"channels of {record.name} over time") for record in self.records[:3])
        return super()._repr_html_() + drawn


def write_mapping(mapping: Mapping, path: FilePath, force: bool = False, columns: Sequence[DraftColumn] = ()) -> None:
    """Write a mapping as YAML, with the reasons for its lines; BadInput where the file exists or cannot be written."""
    if not force:
        refuse_existing([Path(path)])
    replace_together({Path(path): content_writer(mapping_text(mapping, columns))})


def _says_the_same(place: Path, mapping: Mapping) -> bool:
    """Whether a file is a mapping with the same columns: the one that the import was made with."""
    if not place.is_file():
        return False
    try:
        return set(map(repr, mapping.tables)) <= set(map(repr, read_mapping(place).tables))
    except BadInput:
        return False


def _aside_writer(table: Dict[str, Sequence[object]]) -> Callable[[Path], object]:
    """A function that writes columns as CSV."""

    def write(place: Path) -> None:
        without_formula = above("reporting.tables").without_formula
        with place.open("w", encoding="utf-8", newline="") as file:
            writer = csv.writer(file)
            cells = zip(*table.values(), strict=True)
            for row in (table, *cells):
                writer.writerow([without_formula(cell) if isinstance(cell, str) else cell for cell in row])

    return write
