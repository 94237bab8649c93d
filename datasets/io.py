"""Reading and writing records: CSV or Parquet, with an optional YAML sidecar of the same stem.

Accepted columns are the canonical ones (`columns.CANONICAL`) and the same quantities in other units, converted on
reading: ``_deg``, ``_deg_s``, ``_kn``, ``_rpm`` and ``_ms``, which means milliseconds for time and metres per second
for speeds. Any other column is bad input, since a misspelt one would otherwise be ignored silently. Blank cells and
``nan`` are gaps. CSV is UTF-8 (a byte order mark may lead), separated by comma, semicolon or tab (whichever the header
uses most), with a decimal point. Row numbers in messages are line numbers as an editor shows them; in Parquet the
first record is row 1.

Constant channels
-----------------
A channel that never changes is usually a failed sensor. It is left out, and the metadata say so (`LEFT_OUT` among what
else is kept); where it is a rudder, or nothing is left but the rudder, it is bad input. These may be constant:

* a set value or the weather: propeller and wind;
* the rudder, where the record itself shows that it was held (a straight course, a turning circle): the heading does
  not swing to both sides by more than `SWING_RAD`, and rudder and rudder command do not contradict each other;
* any channel that the sidecar lists under ``constant:``, which is how to say that it is so on purpose. `write_record`
  lists them, so whatever it has written reads back (a noise-free straight course, a vessel with prescribed speed).
"""

from __future__ import annotations

import csv
import io
import math
import os
import re
import warnings
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, replace
from itertools import islice
from pathlib import Path
from typing import Any, NoReturn

import numpy as np

from ..models.argument_types import typed
from ..models.errors import BadInput
from ..models.files import read_bytes, replace_together, utf8_of
from ..models.memory import bounded_memory, require_memory
from ..models.model import is_model_id
from .arrow_csv import FEWEST_BYTES, FEWEST_ROWS, columns_of_numbers, numbers_of_arrow, short_text, write_csv
from .columns import ACCEPTED, CANONICAL, NUMBER, RUDDERS, SURROUNDINGS, TWIN, check_header, in_order, to_canonical
from .record import LEFT_OUT, Record, RecordMeta, is_side
from .sidecar import read_sidecar, refuse_to_replace, sidecar_path, sidecar_text
from .time_faults import refuse_time_fault, time_fault

MIN_SAMPLES = 10
SWING_RAD = math.radians(5.0)
PARQUET = (".parquet", ".pq")
RAW = (b"PK\x03\x04", b"\xd0\xcf\x11\xe0", b"\x89HDF", b"MATLAB ", b"ULog", b"#ROSBAG", b"SQLite format 3", b"\xa3\x95")
"""First bytes of workbooks, archives and binary logs, which `helmbench import` reads."""
DELIMITERS = ",;\t"
CELL_BYTES, LEAST_PARQUET_BYTES = 32, 2**28
"""Memory of a cell of a Parquet file while it is read and converted, and of the reader itself."""
MOST_PACKED = 2**22
"""Cells of a Parquet file that may take less than a byte each."""
MAY_BE_CONSTANT = ("propeller_rps", *TWIN, *SURROUNDINGS)
EMPTY_CELL = {mark: re.compile(rf"(?:(?<=[{mark}\n\r])(?=[{mark}])|(?<={mark})(?=[\n\r]|\Z))") for mark in DELIMITERS}
GAP = re.compile(r"[+-]?nan", re.IGNORECASE)


@dataclass(frozen=True)
class _Table:
    """Parsed columns under the names of the file, and where sample i stands in it."""

    columns: dict[str, np.ndarray]
    row_of: Callable[[int], int]


# ------------------------------------------------------------------------------------------------ reading


@typed
def read_record(path: str | os.PathLike[str], positive_rudder: str | None = None) -> Record:
    """Read a record and its sidecar.

    Parameters
    ----------
    path : ``.parquet``/``.pq``, or CSV under any other suffix. The record's name is the file's stem.
    positive_rudder : 'port' or 'starboard'; overrides the sidecar. The rudder keeps the sign that it has in the file
        (`Record.turned` maps it to a vessel's).

    Returns
    -------
    Record in SI units and radians.

    Raises
    ------
    BadInput : anything wrong with the file or its sidecar, in one line that names file, row and column: missing,
        unknown or duplicate column, unknown unit, text in a number column, infinite value, wrong encoding, rows of
        unequal length, fewer than 10 samples, time missing, repeated or going back, empty channel, constant rudder, or
        constant channels alone.
    """
    path = Path(path)
    table, meta, constant = _opened(path, positive_rudder)
    _check_samples(table, path)
    channels = to_canonical(table.columns)
    # channels that never change although they should (see the head of this module)
    names = {ACCEPTED[name][0]: name for name in table.columns}
    still = [
        c
        for c in _constant_channels(channels)
        if c not in MAY_BE_CONSTANT and c not in constant and not (c in RUDDERS and _was_held(c, channels))
    ]
    motion = {*channels} - {"time_s", *RUDDERS, *MAY_BE_CONSTANT}
    refused = [c for c in still if c in RUDDERS or motion <= {*still}]
    for channel in refused:
        index = int(np.isfinite(channels[channel]).argmax())
        value = table.columns[names[channel]][index]
        sidecar = sidecar_path(path).name
        hint = f"a dead sensor? leave the column out, or list {channel} under 'constant:' in {sidecar} if meant so"
        _at(table, index, names[channel], path, f"constant channel: {value:.9g} in every row", hint)
    dead = {c: f"{np.nanmin(channels[c]) + 0.0:.6g} {CANONICAL[c]} in every row" for c in still}
    channels = {name: values for name, values in channels.items() if name not in dead}
    meta = replace(meta, extra={**meta.extra, LEFT_OUT: dead} if dead else meta.extra)
    return Record(channels.pop("time_s"), channels, name=path.stem, meta=meta)


def _opened(path: Path, positive_rudder: str | None) -> tuple[_Table, RecordMeta, frozenset[str]]:
    """The table of a record file, unchecked but for the header, its metadata, and the channels declared constant."""
    if positive_rudder is not None and not is_side(positive_rudder):
        raise BadInput(f"positive rudder {positive_rudder!r}", file=path, hint="give 'port' or 'starboard'")
    table = _read(path)
    meta, constant = read_sidecar(sidecar_path(path))
    return table, replace(meta, positive_rudder=positive_rudder or meta.positive_rudder), constant


def read_table(path: Path) -> dict[str, np.ndarray]:
    """The columns (N,) of a record file under the names and in the units of the file, unchecked but for the header.

    Raises
    ------
    BadInput : the file cannot be read, an unknown or missing column, text in a number column.
    """
    return _read(path).columns


def _read(path: Path) -> _Table:
    if not path.exists() and is_model_id(str(path)):
        raise BadInput("is a model, not a record", file=path, hint="give the files of records here")
    return _read_parquet(path) if path.suffix.lower() in PARQUET else _read_csv(path)


# --- CSV


def _read_csv(path: Path) -> _Table:
    data = read_bytes(path)
    # raw logs and models, whose first bytes tell what they are
    if data.startswith(RAW):
        hint = f"'helmbench import {path} -o {path.stem}-record.csv' makes a record of it"
        raise BadInput("is a workbook or a binary log, not a record", file=path, hint=hint)
    if data.lstrip().startswith(b"{"):
        raise BadInput("is JSON, such as a model, not a record", file=path, hint="give the files of records here")
    data = utf8_of(data, path)
    if not data[:4096].strip() and not data.strip():
        raise BadInput("the file is empty", file=path, row=1)
    end = re.search(rb"[\r\n]", data)
    header = data[: end.start()] if end else data
    delimiter = max(DELIMITERS, key=header.decode().count)
    names = [name.strip().strip('"') for name in header.decode().split(delimiter)]
    check_header(names, path, row=1)
    body = data[len(header) :]
    columns = columns_of_numbers(body, names, delimiter) if len(body) >= FEWEST_BYTES else None
    if columns is None:
        columns = _parse_fast(body.decode(), names, delimiter)
    if columns is None:  # cell by cell; BadInput at the first that is no number
        values: list[list[float]] = []
        line = 1
        try:
            for line, row in islice(_rows(data, delimiter), 1, None):
                if len(row) != len(names):
                    decimal_comma = delimiter == "," and len(row) > len(names)
                    wrong = (
                        "write decimals with a point"
                        if decimal_comma
                        else "every row needs as many cells as the header"
                    )
                    raise BadInput(f"{len(row)} cells under {len(names)} columns", file=path, row=line, hint=wrong)
                pairs = zip(row, names, strict=True)
                values.append([_parse_cell(cell.strip(), name, path, line) for cell, name in pairs])
        except csv.Error as error:
            raise BadInput(f"not CSV after this row ({error})", file=path, row=line) from None
        table = np.array(values, dtype=np.float64).reshape(-1, len(names))
        columns = dict(zip(names, table.T, strict=True))
    return _Table(columns, lambda i: next(islice(_rows(data, delimiter), i + 1, None))[0])


def _parse_fast(body: str, names: list[str], delimiter: str) -> dict[str, np.ndarray] | None:
    """All columns (N,) by numpy's strict parser, or None where it meets anything that needs a closer look."""
    lines = EMPTY_CELL[delimiter].sub("nan", body).split("\n")
    with warnings.catch_warnings():
        warnings.simplefilter("error")  # no data
        try:
            table = np.loadtxt(lines, delimiter=delimiter, comments=None, quotechar='"', ndmin=2)
        except (ValueError, UserWarning):
            return None
    return dict(zip(names, np.ascontiguousarray(table.T), strict=True)) if table.shape[1] == len(names) else None


def _rows(data: bytes, delimiter: str) -> Iterator[tuple[int, list[str]]]:
    """(line number, fields) of the header and of every row that is not blank."""
    reader = csv.reader(io.StringIO(data.decode("utf-8"), newline=""), delimiter=delimiter, strict=True)
    return ((reader.line_num, row) for row in reader if row and (len(row) > 1 or row[0].strip()))


def _parse_cell(cell: str, name: str, path: Path, line: int) -> float:
    if not cell or GAP.fullmatch(cell):
        return math.nan
    if NUMBER.fullmatch(cell):
        return float(cell)
    decimal_comma = NUMBER.fullmatch(cell.replace(",", "."))
    hint = "write decimals with a point" if decimal_comma else "leave the cell empty for a gap"
    shown = repr(cell if len(cell) <= 40 else cell[:37] + "...")
    raise BadInput(f"{shown} is not a number", file=path, row=line, column=name, hint=hint)


# --- Parquet


def _read_parquet(path: Path) -> _Table:
    import pyarrow
    from pyarrow import parquet

    data = read_bytes(path)
    if not data:
        raise BadInput("the file is empty", file=path)
    try:
        with bounded_memory(LEAST_PARQUET_BYTES + 2 * len(data)):
            file = parquet.ParquetFile(pyarrow.BufferReader(data))
        cells = file.metadata.num_rows * file.metadata.num_columns
        if cells > max(MOST_PACKED, len(data)):
            said = f"{file.metadata.num_rows} rows in {len(data)} bytes"
            raise BadInput(f"{said}: no log packs so well", file=path, hint="is it a damaged or made-up file?")
        require_memory(CELL_BYTES * cells, f"{path}: {file.metadata.num_rows} rows")
        with bounded_memory(LEAST_PARQUET_BYTES + 2 * len(data) + CELL_BYTES * cells):
            table = file.read()
        names = [str(name) for name in table.column_names]
    except MemoryError:  # Arrow's, too
        raise BadInput("takes more memory than its rows and columns", file=path, hint="it may be damaged") from None
    except (pyarrow.ArrowException, OSError, UnicodeDecodeError):
        raise BadInput("not a Parquet file", file=path, hint="it may be damaged, or CSV under a wrong suffix") from None
    check_header(names, path)
    return _Table({name: _parquet_column(table, name, path) for name in names}, lambda i: i + 1)


def _parquet_column(table: Any, name: str, path: Path) -> np.ndarray:
    import pyarrow

    column = table.column(name)
    kind = column.type
    types = pyarrow.types
    if not any(check(kind) for check in (types.is_integer, types.is_floating, types.is_decimal, types.is_null)):
        row = next((i for i, valid in enumerate(column.is_valid().to_pylist(), start=1) if valid), None)
        message = f"type {kind} where numbers should be"
        raise BadInput(message, file=path, row=row, column=name, hint="store it as float64, gaps as null or nan")
    return numbers_of_arrow(column.cast(pyarrow.float64(), safe=False).combine_chunks())


# --- checks of the samples


def _check_samples(table: _Table, path: Path) -> None:
    """BadInput if too short, if the time is unusable, if a value is infinite or a column empty."""
    n = len(next(iter(table.columns.values())))
    if n < MIN_SAMPLES:
        last = table.row_of(n - 1) if n else 1
        raise BadInput(f"too short: {n} samples", file=path, row=last, hint=f"a record needs {MIN_SAMPLES}")
    name = next(name for name in table.columns if ACCEPTED[name][0] == "time_s")
    time = table.columns[name]
    bad = ~np.isfinite(time)
    if bad.any():
        index = int(bad.argmax())
        message = "time is missing" if np.isnan(time[index]) else "time is infinite"
        _at(table, index, name, path, message, "every row needs its time")
    late = np.flatnonzero(np.diff(time) <= 0.0)
    if late.size:
        index = int(late[0]) + 1
        before, now = time[index - 1], time[index]
        message = f"duplicate time {now:.9g}" if now == before else f"time goes back from {before:.9g} to {now:.9g}"
        _at(table, index, name, path, message, "time must increase from row to row")
    wrong = time_fault(to_canonical({name: time})["time_s"])
    if wrong is not None:
        _at(table, wrong.index, name, path, wrong.message, wrong.hint)
    for name, values in table.columns.items():
        infinite = np.isinf(values)
        if infinite.any():
            _at(table, int(infinite.argmax()), name, path, "infinite value", "leave the cell empty for a gap")
        if np.isnan(values).all():
            _at(table, 0, name, path, "no value in the whole column", "leave the column out")


def _at(table: _Table, index: int, name: str, path: Path, message: str, hint: str) -> NoReturn:
    raise BadInput(message, file=path, row=table.row_of(index), column=name, hint=hint)


def _constant_channels(channels: Mapping[str, np.ndarray]) -> list[str]:
    """Channels of which at least two samples are known and all are equal."""
    return [
        name
        for name, values in channels.items()
        if np.count_nonzero(np.isfinite(values)) > 1 and np.nanmin(values) == np.nanmax(values)
    ]


def _was_held(channel: str, channels: Mapping[str, np.ndarray]) -> bool:
    """Whether the record shows a constant rudder (command) to have been held so rather than to be a dead sensor."""
    twin = channels.get(next(name for name in RUDDERS if name != channel))
    if twin is not None and np.nanmin(twin) != np.nanmax(twin):
        return channel == "rudder_command_rad" and not _swings(twin)
    if "heading_rad" in channels:
        return not _swings(np.unwrap(channels["heading_rad"][np.isfinite(channels["heading_rad"])]))
    if "yaw_rate_rad_s" in channels:
        rate = np.nan_to_num(channels["yaw_rate_rad_s"])
        return not _swings(np.cumsum(rate[:-1] * np.diff(channels["time_s"])))
    return False


def _swings(angle: np.ndarray, blocks: int = 50) -> bool:
    """Whether an angle (N,) moves to both sides by more than `SWING_RAD`; means over blocks, so that noise does not."""
    known = angle[np.isfinite(angle)]
    means = np.array([part.mean() for part in np.array_split(known, min(blocks, known.size))])
    rise = (means - np.minimum.accumulate(means)).max()
    fall = (np.maximum.accumulate(means) - means).max()
    return bool(min(rise, fall) > SWING_RAD)


# --- records whatever their time stamps and values are


@dataclass(frozen=True)
class Repairs:
    """Rows of a file that were left out or moved: without a time, with a time that stood there already, with a time
    earlier than the row before; infinite values by column."""

    rows: int
    timeless: int = 0
    repeated: int = 0
    backwards: int = 0
    infinite: tuple[tuple[str, int], ...] = ()


def read_leniently(path: str | os.PathLike[str], positive_rudder: str | None = None) -> tuple[Record, Repairs]:
    """Read a record file and correct what keeps it from being a record, to say all that is wrong with it.

    Rows without a time are left out, rows are put in the order of their times, of rows with the same time the first is
    kept, and infinite values are gaps.

    Parameters
    ----------
    path, positive_rudder : as in `read_record`.

    Raises
    ------
    BadInput : the file cannot be read as a table with known columns, fewer than two rows have a time, or the times
        cannot be those of one run (milliseconds as seconds, a clock that was set).
    """
    path = Path(path)
    table, meta, _ = _opened(path, positive_rudder)
    columns = to_canonical(table.columns)
    time = columns.pop("time_s")
    own = np.flatnonzero(np.isfinite(time))
    steps = np.diff(time[own])
    ordered = own[np.argsort(time[own], kind="stable")]
    kept = ordered[np.concatenate([[True], np.diff(time[ordered]) > 0.0])] if ordered.size else ordered
    if kept.size < 2:
        raise BadInput("fewer than two rows have a time of their own", file=path, column="time_s")
    infinite = tuple((name, int(np.isinf(v).sum())) for name, v in columns.items() if np.isinf(v).any())
    refuse_time_fault(time[kept], path)
    channels = {name: np.where(np.isinf(v), np.nan, v)[kept] for name, v in columns.items()}
    repairs = Repairs(time.size, time.size - own.size, ordered.size - kept.size, int(np.sum(steps < 0.0)), infinite)
    return Record(time[kept], channels, name=path.stem, meta=meta), repairs


# ------------------------------------------------------------------------------------------------ writing


@typed
def write_record(record: Record, path: str | os.PathLike[str]) -> None:
    """Write a record and its sidecar; numbers are exact, gaps are empty cells (null in Parquet).

    Parameters
    ----------
    record : at least 10 samples, with a rudder, without infinite values and empty channels.
    path : ``.csv`` or ``.parquet``; the sidecar goes beside it as ``.yaml``. Files that exist are replaced, each in
        one step, once both are complete.

    Raises
    ------
    BadInput : the record could not be read back, the suffix is another, the place cannot be written to, or another
        YAML file, such as a vessel's, lies where the sidecar goes. Nothing is written then.
    """
    replace_together(record_writers(record, Path(path)))


def record_writers(record: Record, path: Path) -> dict[Path, Callable[[Path], object]]:
    """Place -> function that writes it, of a record and its sidecar; BadInput as `write_record`."""
    suffix = path.suffix.lower()
    if suffix not in (".csv", *PARQUET):
        raise BadInput(f"cannot write {suffix or 'a file without suffix'}", file=path, hint="use .csv or .parquet")
    write = _write_csv if suffix == ".csv" else _write_parquet
    columns = {name: record.column(name) for name in in_order(["time_s", *record.channels])}
    check_header(list(columns), path)
    _check_samples(_Table(columns, lambda i: i + 2), path)
    constant = [name for name in _constant_channels(record.channels) if name not in MAY_BE_CONSTANT]
    text = sidecar_text(record.meta, constant)
    sidecar = path.with_suffix(".yaml")
    refuse_to_replace(sidecar)
    return {path: lambda place: write(columns, place), sidecar: lambda place: place.write_text(text, "utf-8")}


def _write_csv(columns: dict[str, np.ndarray], path: Path) -> None:
    """Shortest decimals that read back as the same float64."""
    if len(next(iter(columns.values()))) >= FEWEST_ROWS and write_csv(columns, path):
        return
    cells = [map(short_text, column.tolist()) for column in columns.values()]
    rows = map(",".join, zip(*cells, strict=True))
    path.write_text("\n".join([",".join(columns), *rows, ""]), "utf-8", newline="\n")


def _write_parquet(columns: dict[str, np.ndarray], path: Path) -> None:
    import pyarrow
    from pyarrow import parquet

    table = pyarrow.table({name: pyarrow.array(values, from_pandas=True) for name, values in columns.items()})
    parquet.write_table(table, path)
