"""Import of raw logs as records, and its outcome with tables and files."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass, replace
from os import PathLike
from pathlib import Path
from typing import TYPE_CHECKING, Any

from ..datasets.importing.importer import Drafted, ImportOptions, draft_tables, raw_series, read_all
from ..datasets.importing.mapping import read_mapping, with_columns
from ..datasets.importing.result import Import, write_mapping
from ..datasets.record import Record, is_side
from ..models.argument_types import typed
from ..models.errors import BadInput
from ..models.result import Result
from .arguments import listed

if TYPE_CHECKING:
    import numpy as np

    from ..datasets.importing.mapping import Mapping as ColumnMapping
    from ..datasets.importing.raw import RawTable
    from ..datasets.importing.result import ImportFault
    from .arguments import Path as FilePath


@dataclass(frozen=True, eq=False, repr=False)
class ImportDraft(Drafted, Result):
    """What every column of a log is taken for, before it is imported.

    Questions are answered by `answer`, which gives a new draft; `import_log` imports the log where none is open.

    Attributes
    ----------
    columns : every column of every table, in the order of the files.
    questions : what no one stated.
    mapping : the columns as a mapping, '?' where a question is open; None where no table holds a time.
    faults : what is wrong with the files.
    """

    room = "importing"
    _outcome: Import | ImportFault
    _tables: tuple[RawTable, ...]
    _given: _Given

    def answer(self, answers: Mapping[str, str]) -> ImportDraft:
        """The draft with further answers: id of a question -> key of the answer, or a number where one may be given.

        Raises
        ------
        BadInput : an answer is none of its question.
        """
        if not answers:
            return self
        every = {**self._given.answers, **answers}
        return _drafted(self._tables, replace(self._given, answers=every))

    def with_columns(self, said: Mapping[tuple[str, str], Mapping[str, Any]]) -> ImportDraft:
        """The draft with columns that the user says: (table, column) -> `to`, a quantity or 'not used', `unit`, `sign`.

        Raises
        ------
        BadInput : no table of the log has a time, or a column cannot be what is said.
        """
        if self.mapping is None:
            raise BadInput("no table of the log has a time", hint="see `faults`")
        return _drafted(self._tables, replace(self._given, mapping=with_columns(self.mapping, said)))

    def turned_columns(self) -> set[tuple[str, str]]:
        """Table and column of every column whose sign is turned round."""
        tables = () if self.mapping is None else self.mapping.tables
        return {(table.label, column.column) for table in tables for column in table.columns if column.sign == -1}

    def series(self, table: str, column: str) -> tuple[np.ndarray, np.ndarray]:
        """Times (N,), s, or row numbers where no time is known, and the column's numbers (N,) as in the file.

        Raises
        ------
        BadInput : no such column.
        """
        return raw_series(self._tables, self, table, column)

    def import_log(self) -> Import:
        """The log as records; BadInput where questions are open or the log cannot be records."""
        if isinstance(self._outcome, BadInput):
            raise self._outcome.with_traceback(None)
        found = self._outcome
        return replace(found, records=_segments(found.records)) if self._given.segment else found

    def write_mapping(self, path: FilePath, *, force: bool = False) -> None:
        """Write the mapping, to be changed by hand; BadInput where there is none or the file cannot be written."""
        if self.mapping is None:
            raise BadInput("no table of the log has a time", hint="see `faults`")
        write_mapping(self.mapping, path, force, self.columns)

    def to_dict(self) -> dict[str, object]:
        """Columns, questions and faults as plain data for JSON."""
        from ..datasets.importing.draft import plain

        return {
            "columns": plain(self.columns),
            "questions": [asdict(question) for question in self.questions],
            "faults": [vars(fault) for fault in self.faults],
        }

    def __repr__(self) -> str:
        return f"<ImportDraft of {len(self.columns)} columns, {len(self.questions)} open questions>"


@dataclass(frozen=True, eq=False)
class _Given:
    """What the user said of a log."""

    mapping: ColumnMapping | None
    options: ImportOptions
    answers: Mapping[str, str]
    segment: bool


@typed
def draft_import(
    paths: FilePath | Sequence[FilePath],
    *,
    mapping: ColumnMapping | FilePath | None = None,
    answers: Mapping[str, str] | None = None,
    vessel: str | None = None,
    positive_rudder: str | None = None,
    step_s: float | None = None,
    variation_deg: float | None = None,
    segment: bool = False,
) -> ImportDraft:
    """Read raw logs and say what every column is taken for, what tells it, and what no one states.

    Parameters and errors as in `import_log`; open questions are no error here.
    """

    if positive_rudder is not None and not is_side(positive_rudder):
        raise BadInput(f"positive rudder {positive_rudder!r}", hint="give 'port' or 'starboard'")
    if step_s is not None and not step_s > 0.0:
        raise BadInput(f"step {step_s!r}", hint="give seconds above 0")
    known = read_mapping(Path(mapping)) if isinstance(mapping, str | PathLike) else mapping
    options = ImportOptions(vessel, positive_rudder, step_s, variation_deg)
    return _drafted(tuple(read_all(listed(paths))), _Given(known, options, answers or {}, segment))


@typed
def import_log(
    paths: FilePath | Sequence[FilePath],
    *,
    mapping: ColumnMapping | FilePath | None = None,
    answers: Mapping[str, str] | None = None,
    vessel: str | None = None,
    positive_rudder: str | None = None,
    step_s: float | None = None,
    variation_deg: float | None = None,
    segment: bool = False,
) -> Import:
    """Read raw logs of any make as records.

    Text with any separator, decimal sign, encoding and header, Excel workbooks (xlsx), MAT files (version 7 or
    earlier) and NMEA 0183.  Quantity, unit and sign of each column are taken from what the file states, from its other
    channels and from what is physically possible; what none of these tells is a question, and the import ends with it.
    Positions in degrees become north and east, speed and course over ground become surge and sway.  Several loggers are
    put on one time base.

    Parameters
    ----------
    paths : one file or several, of one logger or several.
    mapping : the mapping of an earlier import, or the path of its file; None: told by the log.
    answers : id of a question -> key of its answer; see `draft_import`.
    vessel : id of the vessel, for the sidecar.
    positive_rudder : 'port' or 'starboard', the side of a positive rudder; None: told by the yaw response.
    step_s : time step of the records, s; None: that of the log, of several loggers that of the slowest.
    variation_deg : magnetic variation, deg to east, for a magnetic heading.
    segment : cut the records into zigzags, turns and straight runs.

    Raises
    ------
    BadInput : the logs cannot be records; all that is wrong is told at once.
    """
    return draft_import(
        paths,
        mapping=mapping,
        answers=answers,
        vessel=vessel,
        positive_rudder=positive_rudder,
        step_s=step_s,
        variation_deg=variation_deg,
        segment=segment,
    ).import_log()


def _drafted(tables: Sequence[RawTable], given: _Given) -> ImportDraft:
    from ..models.linear_algebra import blas_limited

    with blas_limited():
        drafted, outcome = draft_tables(tables, given.mapping, given.options, given.answers)
    return ImportDraft(**vars(drafted), _outcome=outcome, _tables=tuple(tables), _given=given)


def _segments(records: Sequence[Record]) -> tuple[Record, ...]:
    """The zigzags, turns and straight runs of records; the records themselves where there are none."""
    from ..datasets.importing.segments import cut

    return tuple(part for record in records for _, part in cut(record)) or tuple(records)


def list_quantities() -> dict[str, list[str]]:
    """What a column of a log can be -> the units that its numbers can have, the usual one first."""
    from ..datasets.importing.quantities import UNITS, candidates, quantities

    usual = {one.dimension: [unit.name for unit in candidates(one.dimension)] for one in quantities().values()}
    return {
        name: [
            *usual[one.dimension],
            *(u.name for u in UNITS.values() if u.dimension == one.dimension and u.name not in usual[one.dimension]),
        ]
        for name, one in quantities().items()
    }
