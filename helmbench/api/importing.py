"""Import of raw logs as records, and its outcome with tables and files."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from os import PathLike, fspath
from pathlib import Path
from typing import TYPE_CHECKING

from ..models.errors import BadInput

if TYPE_CHECKING:
    from ..datasets.importing.importer import Aside
    from ..datasets.importing.mapping import Mapping as ColumnMapping
    from ..datasets.importing.report import ImportReport
    from ..datasets.record import Record
    from .identification import Path as FilePath


@dataclass(frozen=True, eq=False, repr=False)
class Import:
    """The outcome of `import_log`.

    records : one record, or one a run, or one a manoeuvre where the log was cut.  mapping : what every column was taken
    for, to be used again.  report : columns with confidence, what was done, and faults that did not end the import.
    aside : table -> column -> samples (N,) of columns that are no channel.
    """

    records: tuple[Record, ...]
    mapping: ColumnMapping
    report: ImportReport
    aside: Aside

    @property
    def record(self) -> Record:
        """The record; BadInput where the log holds several."""
        if len(self.records) != 1:
            names = ", ".join(record.name for record in self.records)
            raise BadInput(f"the log holds {len(self.records)} records", hint=f"take one of `records`: {names}")
        return self.records[0]

    def summary(self) -> str:
        """Columns, steps and faults as text."""
        from ..reporting.importing import terminal

        return terminal(self.report, self.records)

    def write(self, path: FilePath, *, force: bool = False) -> tuple[Path, ...]:
        """Write the records with their sidecars, the mapping, and the columns that are kept aside: all or none.

        Parameters
        ----------
        path : of the record, .csv or .parquet; several records get their names behind its stem.  Beside it go
            STEM.map.yaml and STEM.aside.csv.
        force : replace files that exist.

        Returns
        -------
        The paths of all files but the sidecars.

        Raises
        ------
        BadInput : a file exists, or cannot be written.
        """
        from ..datasets.importing.mapping import mapping_text
        from ..datasets.io import record_writers
        from ..models.files import refuse_existing, replace_together
        from .documents import text_writer

        path = Path(path)
        places = self._places(path)
        writers: dict[Path, Callable[[Path], object]] = {}
        for place, record in zip(places, self.records, strict=True):
            writers |= record_writers(record, place)
        writers[path.with_name(f"{path.stem}.map.yaml")] = text_writer(mapping_text(self.mapping))
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
        write_mapping(self.mapping, path, force)

    def _places(self, path: Path) -> list[Path]:
        """Where each record is written."""
        if len(self.records) == 1:
            return [path]
        return [path.with_name(f"{path.stem}-{record.name}{path.suffix}") for record in self.records]

    def __repr__(self) -> str:
        return f"<Import of {', '.join(record.name for record in self.records)}>"

    def _repr_html_(self) -> str:
        from ..reporting.importing import notebook

        return notebook(self.report, self.records)


def import_log(
    paths: FilePath | Sequence[FilePath],
    *,
    mapping: ColumnMapping | FilePath | None = None,
    vessel: str | None = None,
    positive_rudder: str | None = None,
    step_s: float | None = None,
    variation_deg: float | None = None,
    segment: bool = False,
) -> Import:
    """Read raw logs of any make as records.

    Text with any separator, decimal sign, encoding and header, Excel workbooks (xlsx), MAT files (version 7 or
    earlier) and NMEA 0183.  Quantity, unit and sign of each column are guessed from names, units, ranges and from each
    other; look at `report` before the records are used.  Positions in degrees become north and east, speed and course
    over ground become surge and sway.  Several loggers are put on one time base.

    Parameters
    ----------
    paths : one file or several, of one logger or several.
    mapping : the mapping of an earlier import, or the path of its file; None: guessed.
    vessel : id of the vessel, for the sidecar.
    positive_rudder : 'port' or 'starboard'; None: told by the yaw response.
    step_s : time step of the records; None: that of the log, of several loggers that of the slowest.
    variation_deg : magnetic variation, positive to east, for a magnetic heading.
    segment : cut the records into zigzags, turns and straight runs.

    Raises
    ------
    BadInput : the logs cannot be records; all that is wrong is told at once.
    """
    from ..datasets.importing.importer import Options, import_tables
    from ..datasets.importing.mapping import read_mapping
    from ..datasets.importing.segments import cut
    from ..datasets.record import is_side

    if positive_rudder is not None and not is_side(positive_rudder):
        raise BadInput(f"positive rudder {positive_rudder!r}", hint="give 'port' or 'starboard'")
    if step_s is not None and not step_s > 0.0:
        raise BadInput(f"step {step_s!r}", hint="give seconds above 0")
    files = [paths] if isinstance(paths, str | PathLike) else list(paths)
    known = read_mapping(Path(mapping)) if isinstance(mapping, str | PathLike) else mapping
    options = Options(vessel, positive_rudder, step_s, variation_deg)
    found = import_tables([fspath(file) for file in files], known, options)
    records = found.records
    if segment:
        records = tuple(part for record in records for _, part in cut(record)) or records
    return Import(records, found.mapping, found.report, found.aside)


def write_mapping(mapping: ColumnMapping, path: FilePath, force: bool = False) -> None:
    """Write a mapping as YAML; BadInput where the file exists or cannot be written."""
    from ..datasets.importing.mapping import mapping_text
    from ..models.files import refuse_existing, replace_together
    from .documents import text_writer

    if not force:
        refuse_existing([Path(path)])
    replace_together({Path(path): text_writer(mapping_text(mapping))})


def _aside_writer(table: Mapping[str, Sequence[object]]) -> Callable[[Path], object]:
    """A function that writes columns as CSV."""

    def write(place: Path) -> None:
        import csv

        with place.open("w", encoding="utf-8", newline="") as file:
            writer = csv.writer(file)
            writer.writerow(table)
            writer.writerows(zip(*table.values(), strict=True))

    return write
