"""Any raw log as raw tables: the kind of a file is told by its content, also within a compressed one."""

from __future__ import annotations

import io
import os
import zipfile
import zlib
from collections import Counter
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path, PurePosixPath

import numpy as np

from ...models.errors import BadInput
from ...models.files import MOST_BYTES, read_bytes
from .beside import with_sidecar
from .cells import Texts
from .contained import read_contained
from .formats.autopilots import read_dataflash, with_messages, with_px4
from .formats.json_records import read_json, with_signal_k
from .formats.n2k import read_n2k
from .formats.named_values import read_named_values
from .formats.plain_tables import as_plain_table
from .formats.programs import looks_like_sbet, read_alog, read_hypack, read_influx, read_sbet, read_track, with_pospac
from .formats.ros import with_ros
from .headers import read_header
from .instruments import by_instrument
from .layout import distinct, read_parts
from .names import is_time, joined, listed, named
from .nmea import read_nmea
from .raw import RawColumn, RawTable
from .text import LONGEST, MOST_COLUMNS, decoded, read_text
from .times import find_time

TEXTS: tuple[Callable[[str, Path], list[RawTable] | None], ...] = (
    read_track, read_n2k, read_json, read_dataflash, read_hypack, read_influx, read_alog,
    read_nmea, read_named_values,
)  # fmt: skip
"""Readers of texts that are told by their first lines; None of one that is not theirs."""

HTML = ("a page of HTML", "open it in a spreadsheet program and save it as xlsx or CSV")
REFUSED = {
    b"\xd0\xcf\x11\xe0": ("an Excel file of the old form (xls)", "save it as xlsx or CSV"),
    b"%PDF": ("a PDF", "export the log as CSV"),
    **dict.fromkeys((b"<html", b"<HTML", b"<!DOCTYPE html", b"<table"), HTML),
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
    # where it is empty, or of a kind that is not read
    data = read_bytes(path)
    _refuse(data, path)
    files = contents_of(data, path)
    if len(files) > 1 or files[0][0] != path:
        out: list[RawTable] = []
        wrong: list[tuple[Path, BadInput]] = []
        for name, content in files:  # those without any table are left out where others have some
            try:
                called = name.relative_to(path).as_posix() if len(files) > 1 else name.name
                _refuse(content, name)
                if content.startswith(BAGS) or is_compressed(content):
                    raise BadInput("a ROS bag or a compressed file within another", file=name, hint="unpack it first")
                out += [replace(table, file=called) for table in _of_content(content, name)]
            except BadInput as error:
                wrong.append((name, error))
        if not out:
            raise wrong[0][1]
        left = [f"{name.name} is not used: {error.message}" for name, error in wrong]
        out[0] = replace(out[0], done=(f"unpacked from {path.name}", *left, *out[0].done))
        return out
    return _of_content(files[0][1], path)


def _of_content(data: bytes, path: Path) -> list[RawTable]:
    """The raw tables of the content of a file."""
    tables = _tables(data, path)
    if len(tables) > MOST_TABLES:
        longest = sorted(range(len(tables)), key=lambda i: -tables[i].n)[:MOST_TABLES]
        said = f"{len(tables)} tables, the {MOST_TABLES} with the most rows are read"
        first, *others = (tables[i] for i in sorted(longest))
        tables = [replace(first, done=(said, *first.done)), *others]
    sheets = distinct([table.sheet for table in tables])  # no two have the same
    tables = [replace(table, sheet=sheet) for table, sheet in zip(tables, sheets, strict=True)]
    tables = [with_dropouts(without_statistics(table)) for table in tables]
    # labels of the tables of a file with equal headers that hold a rudder and what tells the turning each: runs, each
    # with a clock of its own
    headers = {table.label: tuple((c.name, c.unit) for c in table.columns) for table in tables}
    counts = Counter(headers.values())
    alike = {table.label for table in tables if counts[headers[table.label]] > 1 and _is_whole(table)}
    clocks = [f"{path} {table.sheet}" if table.label in alike else str(path) for table in tables]
    tables = [_oldest_first(replace(table, clock=clock)) for table, clock in zip(tables, clocks, strict=True)]
    return with_sidecar(tables, path)


def _is_whole(table: RawTable) -> bool:
    """Whether the names of a table, of no format, are those of a rudder and a heading or yaw rate, among others."""
    may_be = {q for c in table.columns if not c.known for q in named(read_header(c.called or c.name).words).may_be}
    return bool(may_be & {"rudder", "rudder_command"}) and bool(may_be & {"heading", "yaw_rate"})


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


# ---- Rows of a table that are no samples: statistics above or below the data, zeros where a logger had no data.

ENDS = 12
"""Rows at either end of a table among which those of statistics are."""
FEWEST, MOST = 3, 0.5
"""Columns that are 0 together where a logger has no data, and the share of rows that may be so."""
FAR = 0.2
"""Least size of a signal, as a share of its median, from which on it never comes near 0."""


def without_statistics(table: RawTable) -> RawTable:
    """A table without the rows at its ends that a cell calls a minimum, a mean or the like."""
    ends = sorted({*range(min(ENDS, table.n)), *range(max(0, table.n - ENDS), table.n)})
    called = {row: text for c in table.columns if c.texts is not None for row in ends if _is_one(text := c.text(row))}
    if not called or len(called) > table.n // 2:
        return table
    kept = np.setdiff1d(np.arange(table.n), list(called))
    faults = [(int(table.rows[row]), f"a row of statistics ({text})", text) for row, text in sorted(called.items())]
    return table.at(kept, faults=(*table.faults, *faults))


def _is_one(text: str) -> bool:
    """Whether a cell is the name of a statistic."""
    return bool(text) and not text[0].isdigit() and joined(text) in listed("statistics")


def with_dropouts(table: RawTable) -> RawTable:
    """A table with gaps in the rows where all its numbers are 0 although two of three, or one of more, never come near
    that."""
    columns = [c for c in table.columns if c.numeric and not c.known and not is_time(c.name)]
    rising = [c.finite.size > 1 and float(np.mean(np.diff(c.finite) > 0.0)) > 0.95 for c in columns]
    columns = [c for c, up in zip(columns, rising, strict=True) if not up and np.any(np.nan_to_num(c.numbers))]
    if len(columns) < FEWEST:
        return table
    nothing = np.logical_and.reduce([c.numbers == 0.0 for c in columns])
    if not 0 < nothing.sum() < MOST * table.n:
        return table
    sizes = [np.abs(c.numbers[~nothing & np.isfinite(c.numbers)]) for c in columns]  # of which some never come near 0
    far = sum(bool(own.size) and float(own.min()) > FAR * float(np.median(own)) for own in sizes)
    if far < (1 if len(columns) > FEWEST else 2):
        return table
    done = f"{int(nothing.sum())} rows hold 0 in all {len(columns)} columns: taken as gaps"
    own = {c.name for c in columns}

    def told(c: RawColumn) -> RawColumn:
        gaps = (
            Texts(np.where(nothing, "", c.texts.array)) if c.texts is not None else np.where(nothing, np.nan, c.numbers)
        )
        return replace(c, values=gaps) if c.name in own else c

    return table.told(told, done)


# ---- Files within compressed ones: of gzip, and of zip archives.

GZIP, ZIP = b"\x1f\x8b", b"PK\x03\x04"
OFFICE = ("[Content_Types].xml", "mimetype", "content.xml")
"""Members by which a zip archive is a document of an office program: a workbook is read as one."""
MOST_MEMBERS = 200
"""Files of an archive that are read."""
HIDDEN = ("__MACOSX/", ".")
"""How names of files begin that systems add to an archive."""


def is_compressed(data: bytes) -> bool:
    """Whether the content of a file is compressed, and not the document of an office program."""
    document = any(name.encode() in data[:2000] or name.encode() in data[-20000:] for name in OFFICE)
    return data.startswith(GZIP) or (data.startswith(ZIP) and not document)


def contents_of(data: bytes, path: Path) -> list[tuple[Path, bytes]]:
    """(name, bytes) of the files within a compressed file; the file itself where it is none.

    A file of gzip is called as without `.gz`, one of an archive by its name in that.  Of a file of gzip that was cut
    the beginning is read.

    Raises
    ------
    BadInput : the file is damaged, encrypted, too large when unpacked, or holds no or too many files.
    """
    if data.startswith(GZIP):
        # of all its parts
        out, size, rest = [], 0, data
        while rest.startswith(GZIP):
            part = zlib.decompressobj(wbits=31)
            try:
                out.append(part.decompress(rest, MOST_BYTES - size + 1))
            except zlib.error:
                if not out or not any(out):
                    raise BadInput("a damaged file of gzip", file=path, hint="is it whole?") from None
                break
            size += len(out[-1])
            if size > MOST_BYTES:
                raise _too_large(path)
            rest = part.unused_data
        found = b"".join(out)
        if found[257:262] == b"ustar":
            raise BadInput("a compressed tar archive", file=path, hint="unpack it first")
        return [(path.with_suffix("") if path.suffix.lower() == ".gz" else path, found)]
    if is_compressed(data):
        return _members(data, path)
    return [(path, data)]


def _members(data: bytes, path: Path) -> list[tuple[Path, bytes]]:
    out, size = [], 0
    try:
        with zipfile.ZipFile(io.BytesIO(data)) as archive:
            names = [i.filename for i in archive.infolist() if not i.is_dir() and not i.filename.startswith(HIDDEN)]
            if len(names) > MOST_MEMBERS:
                raise BadInput(f"an archive of {len(names)} files", file=path, hint=f"at most {MOST_MEMBERS} are read")
            for name in names:
                with archive.open(name) as member:
                    own = member.read(MOST_BYTES - size + 1)
                size += len(own)
                if size > MOST_BYTES:
                    raise _too_large(path)
                parts = PurePosixPath(name.replace("\\", "/")).parts
                out.append((path.joinpath(*(p for p in parts if p not in ("/", ".."))), own))  # never out of it
    except BadInput:
        raise
    except (zipfile.BadZipFile, zlib.error, NotImplementedError, RuntimeError, EOFError, ValueError, OSError) as error:
        said = (
            "an encrypted archive" if "encrypted" in str(error) else "a damaged archive, or of a kind that is not read"
        )
        raise BadInput(said, file=path, hint="unpack it first") from None
    if not out:
        raise BadInput("an archive without files", file=path)
    return out


def _too_large(path: Path) -> BadInput:
    return BadInput(f"a compressed file of more than {MOST_BYTES / 2**30:.2g} GiB", file=path, hint="unpack it first")
