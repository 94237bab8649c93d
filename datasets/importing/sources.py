"""Any raw log as raw tables: the kind of a file is told by its content."""

from __future__ import annotations

import os
from collections import Counter
from collections.abc import Callable, Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np

from ...models.errors import BadInput
from ...models.files import read_bytes
from .beside import with_sidecar
from .compressed import contents_of, is_compressed
from .contained import read_contained
from .formats.autopilots import read_dataflash, with_px4
from .formats.influx import read_influx
from .formats.json_records import read_json
from .formats.messages import with_messages
from .formats.n2k import read_n2k
from .formats.named_values import read_named_values
from .formats.plain_tables import as_plain_table
from .formats.programs import read_alog, read_hypack, read_track
from .formats.ros import with_ros
from .formats.sbet import looks_like_sbet, read_sbet, with_pospac
from .formats.signalk import with_signal_k
from .headers import read_header
from .instruments import by_instrument
from .layout import distinct
from .names import named
from .nmea import read_nmea
from .no_samples import with_dropouts, without_statistics
from .raw import RawTable
from .several_tables import read_parts
from .text import LONGEST, MOST_COLUMNS, decoded, read_text
from .times import find_time

TEXTS: tuple[Callable[[str, Path], list[RawTable] | None], ...] = (
    read_track, read_n2k, read_json, read_dataflash, read_hypack, read_influx, read_alog,
    read_nmea, read_named_values,
)  # fmt: skip
"""Readers of texts that are told by their first lines; None of one that is not theirs."""

REFUSED = {
    b"\xd0\xcf\x11\xe0": ("an Excel file of the old form (xls)", "save it as xlsx or CSV"),
    b"%PDF": ("a PDF", "export the log as CSV"),
}
BINARY = {
    b"PK": "a workbook",
    b"MATLAB 7.3": "an HDF5 file",
    b"MATLAB": "a MAT file",
    b"CDF\x01": "a netCDF file",
    b"CDF\x02": "a netCDF file",
    b"\x89HDF": "an HDF5 file",
    b"PAR1": "a Parquet file",
    b"ARROW1": "an Arrow file",
    b"ULog\x01\x12\x35": "a PX4 log",
    b"\xa3\x95": "an ArduPilot log",
}
"""First bytes of a file -> its kind, read in a process of its own."""
BAGS = (b"#ROSBAG", b"SQLite format 3\0", b"\x89MCAP")
HEAD = 200
"""Rows that tell whether the newest one stands first."""
MOST_TABLES = 200
"""Tables of a file that are read."""
METADATA = "metadata.yaml"
"""The file in the folder of a ROS 2 bag."""


def read_raw(path: str | os.PathLike[str]) -> list[RawTable]:
    """The raw tables of a file, one or more, or of the folder of a ROS 2 bag.

    Raises
    ------
    BadInput : the file cannot be read, or holds no table of a kind that is known.
    """
    path = Path(path)
    if path.is_dir():
        if not (path / METADATA).is_file():
            raise BadInput("is a directory", file=path, hint="name the log files in it")
        return [replace(table, clock=str(path)) for table in read_contained("a ROS bag", b"", path)]
    files = contents_of(_content(path), path)
    if len(files) > 1 or files[0][0] != path:
        return _of_compressed(files, path)
    return _of_content(files[0][1], path)


def _of_compressed(files: Sequence[tuple[Path, bytes]], path: Path) -> list[RawTable]:
    """The tables of the files within a compressed one; those without any are left out where others have some."""
    out: list[RawTable] = []
    wrong: list[tuple[Path, BadInput]] = []
    for name, data in files:
        try:
            called = name.relative_to(path).as_posix() if len(files) > 1 else name.name
            _refuse(data, name)
            if data.startswith(BAGS) or is_compressed(data):
                raise BadInput("a ROS bag or a compressed file within another", file=name, hint="unpack it first")
            out += [replace(table, file=called) for table in _of_content(data, name)]
        except BadInput as error:
            wrong.append((name, error))
    if not out:
        raise wrong[0][1]
    left = [f"{name.name} is not used: {error.message}" for name, error in wrong]
    out[0] = replace(out[0], done=(f"unpacked from {path.name}", *left, *out[0].done))
    return out


def _of_content(data: bytes, path: Path) -> list[RawTable]:
    """The raw tables of the content of a file."""
    tables = [with_dropouts(without_statistics(table)) for table in _told_apart(_tables(data, path))]
    alike = _alike(tables)
    clocks = [f"{path} {table.sheet}" if table.label in alike else str(path) for table in tables]
    tables = [_oldest_first(replace(table, clock=clock)) for table, clock in zip(tables, clocks, strict=True)]
    return with_sidecar(tables, path)


def _alike(tables: Sequence[RawTable]) -> set[str]:
    """Labels of the tables of a file with equal headers that hold a rudder and what tells the turning each: runs, each
    with a clock of its own."""
    headers = {table.label: tuple((c.name, c.unit) for c in table.columns) for table in tables}
    counts = Counter(headers.values())
    return {table.label for table in tables if counts[headers[table.label]] > 1 and _is_whole(table)}


def _is_whole(table: RawTable) -> bool:
    """Whether the names of a table, of no format, are those of a rudder and a heading or yaw rate, among others."""
    may_be = {q for c in table.columns if not c.known for q in named(read_header(c.called or c.name).words).may_be}
    return bool(may_be & {"rudder", "rudder_command"}) and bool(may_be & {"heading", "yaw_rate"})


def _content(path: Path) -> bytes:
    """The bytes of a file; BadInput where it is empty, or of a kind that is not read."""
    data = read_bytes(path)
    _refuse(data, path)
    return data


def _refuse(data: bytes, path: Path) -> None:
    """Refuse a file that is empty, or of a kind that is not read."""
    if not data[:4096].strip() and not data.strip():
        raise BadInput("the file is empty", file=path)
    for magic, (what, hint) in REFUSED.items():
        if data.startswith(magic):
            raise BadInput(what, file=path, hint=hint)
    if data.startswith(b"PK") and b"[Content_Types].xml" not in data and b"content.xml" in data:
        raise BadInput("a document of an office program", file=path, hint="save it as xlsx or CSV")


def _oldest_first(table: RawTable) -> RawTable:
    """A table whose newest row stands first, turned round."""
    head = table.at(np.arange(min(table.n, HEAD)))
    time = find_time(head, None, {}).seconds(head) if head.n > 2 else None
    if time is None or not np.mean(np.diff(time[0]) < 0.0) > 0.9:
        return table
    done = (*table.done, "the newest row stands first: turned round")
    return table.at(np.arange(table.n)[::-1], done=done)


def _tables(data: bytes, path: Path) -> list[RawTable]:
    if data.startswith(BAGS):
        return read_contained("a ROS bag", b"", path.parent if (path.parent / METADATA).is_file() else path)
    kind = next((kind for magic, kind in BINARY.items() if data.startswith(magic)), None)
    if kind is not None:
        return [with_ros(_bounded(table, path)) for table in read_contained(kind, data, path)]
    if looks_like_sbet(data):
        return read_sbet(data, path)
    text, encoding = decoded(data, path)
    del data  # of a large file both would fill the memory
    tables = next((found for read in TEXTS if (found := read(text, path)) is not None), None)
    if tables is None:
        text, said = as_plain_table(text)
        parts = read_parts(text, path, lambda part: read_text(part, encoding, path))
        parts = [replace(part, done=(said, *part.done)) for part in parts] if said else parts
        tables = [table for part in parts for table in by_instrument(part)]
    tables = [part for table in tables for part in with_messages(_bounded(table, path))]
    return [with_px4(with_ros(with_pospac(with_signal_k(table)))) for table in tables]


def _told_apart(tables: Sequence[RawTable]) -> list[RawTable]:
    """Tables of a file of which no two have the same sheet, those with the most rows where they are many."""
    if len(tables) > MOST_TABLES:
        longest = sorted(range(len(tables)), key=lambda i: -tables[i].n)[:MOST_TABLES]
        said = f"{len(tables)} tables, the {MOST_TABLES} with the most rows are read"
        tables = [tables[i] for i in sorted(longest)]
        tables = [replace(tables[0], done=(said, *tables[0].done)), *tables[1:]]
    sheets = distinct([table.sheet for table in tables])
    return [replace(table, sheet=sheet) for table, sheet in zip(tables, sheets, strict=True)]


def _bounded(table: RawTable, path: Path) -> RawTable:
    """A table whose names can be taken apart in time.

    Raises
    ------
    BadInput : it has too many columns, or a name of too many characters.
    """
    longest = max((len(column.name) for column in table.columns), default=0)
    if len(table.columns) > MOST_COLUMNS or longest > LONGEST:
        said = f"{len(table.columns)} columns with names of up to {longest} characters"
        limit = f"at most {MOST_COLUMNS} columns and {LONGEST} characters are read"
        raise BadInput(f"{said}; {limit}", file=path, hint="export the columns that tell of the ship's motion")
    return table
