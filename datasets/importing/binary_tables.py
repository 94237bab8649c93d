"""Excel workbooks, MAT, HDF5, netCDF, Parquet and Arrow files as raw tables."""

from __future__ import annotations

import datetime
import io
import re
from collections import defaultdict
from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from ...models.errors import BadInput
from ...models.extras import extras_told
from .layout import read_parts
from .moments import moment
from .names import is_time, joined, listed
from .raw import RawColumn, RawTable, usable
from .text import read_text

SINCE = re.compile(r"(?P<unit>[a-z]+) since (?P<start>\d.*)", re.IGNORECASE)
"""The unit of a time with its start (Climate and Forecast conventions 1.11, section 4.4)."""
SECONDS = {"days": 86400.0, "day": 86400.0, "hours": 3600.0, "hour": 3600.0, "minutes": 60.0, "minute": 60.0,
           "seconds": 1.0, "second": 1.0, "s": 1.0, "milliseconds": 1e-3, "microseconds": 1e-6}  # fmt: skip
FEWEST = 10
"""Samples below which an array of a MAT file is no time series."""
UNIT_FIELDS = ("units", "unit", "einheiten")
OF_ALL = re.compile(r"\bSI\b")
"""What states the units of all arrays of a file."""


def read_excel(data: bytes, path: Path) -> list[RawTable]:
    """A table for every sheet that holds data; BadInput where none does."""
    import openpyxl

    book = openpyxl.load_workbook(io.BytesIO(data), read_only=True, data_only=True)
    tables, notes = list[RawTable](), list[str]()
    for sheet in book.worksheets:
        rows = [tuple(map(_cell, row)) for row in sheet.iter_rows(values_only=True)]
        used = max((i + 1 for row in rows for i, cell in enumerate(row) if cell), default=0)
        text = "\n".join("\t".join(row[:used]) for row in rows)
        try:
            parts = read_parts(text, path, lambda part: read_text(part, "", path))
            tables += [replace(part, sheet=sheet.title, done=part.done[1:]) for part in parts]
        except BadInput as error:
            notes.append(f"{sheet.title}: {error.message}")
    found = usable(tables, path, "no sheet holds rows of numbers", f"sheets: {'; '.join(notes)}")
    return [replace(found[0], done=(*(f"sheet {note}, not used" for note in notes), *found[0].done)), *found[1:]]


def _cell(value: Any) -> str:
    if value is None:
        return ""
    if isinstance(value, datetime.datetime | datetime.time):
        return value.isoformat(sep=" ") if isinstance(value, datetime.datetime) else value.isoformat()
    return repr(value) if isinstance(value, float) else " ".join(str(value).replace('"', "'").split())


def read_mat(data: bytes, path: Path) -> list[RawTable]:
    """The series of a MAT or HDF5 file: one table for every structure and length of arrays."""
    import scipy.io

    if data.startswith((b"MATLAB 7.3", b"\x89HDF")):
        content, units = hdf_content(data)
        return _with_rate(_tables_of(content, units, path), content)
    content = scipy.io.loadmat(io.BytesIO(data), simplify_cells=True)
    content = {k: v for k, v in content.items() if not k.startswith("__")}
    return _with_rate(_tables_of(content, {}, path), content)


def _with_rate(tables: Sequence[RawTable], content: Mapping[str, Any]) -> list[RawTable]:
    """Tables with the numbers of a file that stand alone, at its top or in a structure of it, as lines above them: one
    of these may be the sampling rate."""
    alone = [
        f"{name} = {float(value):.9g}"
        for part in (content, *(own for own in content.values() if isinstance(own, Mapping)))
        for name, value in part.items()
        if isinstance(value, int | float | np.number) or (isinstance(value, np.ndarray) and value.size == 1
                                                          and value.dtype.kind in "fiu")
    ]  # fmt: skip
    return [replace(table, notes=(*table.notes, *alone)) for table in tables]


def read_netcdf(data: bytes, path: Path) -> list[RawTable]:
    """The series of a classic netCDF file, read by SciPy: one table for every length of arrays."""
    from scipy.io import netcdf_file

    content: dict[str, Any] = {}
    units: dict[str, str] = {}
    with netcdf_file(io.BytesIO(data), "r", mmap=False) as file:
        for name, variable in file.variables.items():
            stated = vars(variable)["_attributes"]
            content[name] = unpacked(np.array(variable[:]) if variable.shape else np.array(variable.data), stated)
            unit = next((text for key in UNIT_ATTRIBUTES if (text := text_of(stated.get(key)))), "")
            units |= {name: unit} if unit else {}
    return _tables_of(content, units, path)


def _tables_of(content: Mapping[str, Any], units: dict[str, str], path: Path) -> list[RawTable]:
    """A table for every structure and length of arrays.

    A structure of units counts for the arrays beside it, and for those of the only structure beside it.
    """
    groups: dict[tuple[str, int], dict[str, np.ndarray]] = defaultdict(dict)
    told: dict[str, dict[str, str]] = {}
    _collect(content, "", groups, told)
    places, stated = {where for where, _ in groups}, dict[str, str]()
    for where, own in told.items():
        below = {place for place in places if place != where and place.rpartition(".")[0] == where}
        for place in {where} | (below if len(below) == 1 else set()):
            stated |= {f"{place}.{name}".strip("."): unit for name, unit in own.items()}
    stated |= units
    tables, every = [], "SI" if "*" in told else ""
    for (where, size), group in groups.items():
        columns = []
        for name, own in group.items():
            alone = len(group) == 2 and joined(name) in listed("values") and where
            unit = stated.get(f"{where}.{name}".strip("."), "" if is_time(name) else every)
            columns.append(_column(where.rpartition(".")[2] if alone else name, unit, own))
        tables += [RawTable.of(path, columns, f"{len(columns)} arrays of {size}", where)] if len(group) > 1 else []
    hint = "series must be numeric arrays of equal length; timeseries objects cannot be read outside MATLAB"
    return usable(tables, path, "no numeric arrays of equal length found", hint)


def _collect(content: Mapping[str, Any], where: str, groups: Any, units: dict[str, dict[str, str]]) -> None:
    """Sort arrays of a structure into groups by structure and length, and structures of units by where they stand."""
    labels = [texts for value in content.values() if (texts := _texts(value))]
    for name, value in content.items():
        if isinstance(value, Mapping):
            if name.lower() in UNIT_FIELDS:
                units[where] = {str(key): str(text) for key, text in value.items() if isinstance(text, str)}
            else:
                value = _simulink(value) if {"time", "signals"} <= set(value) else value
                _collect(value, f"{where}.{name}".strip("."), groups, units)
            continue
        if name.lower() in UNIT_FIELDS and isinstance(value, str) and OF_ALL.search(value):
            units["*"] = {}
        array = np.asarray(value)
        if array.dtype.kind not in "fiub" or array.size < FEWEST or array.ndim > 2:
            continue
        squeezed = np.squeeze(array).astype(float)
        if squeezed.ndim == 1:
            groups[where, squeezed.size][name] = squeezed
            continue
        # the columns of a matrix, with the only labels that are as many, or else with numbered names
        tall = squeezed if squeezed.shape[0] > squeezed.shape[1] else squeezed.T
        fitting = [own for own in labels if len(set(own)) == len(own) == tall.shape[1]]
        names = fitting[0] if len(fitting) == 1 else [f"{name} {i + 1}" for i in range(tall.shape[1])]
        groups[where, tall.shape[0]] |= {called: tall[:, i].copy() for i, called in enumerate(names)}


def _texts(value: Any) -> list[str]:
    """The texts of an array of texts, such as the names of the columns of a matrix beside it; none where it is none."""
    flat = np.ravel(value).tolist() if isinstance(value, np.ndarray | list) else []
    return [text.strip() for text in flat] if len(flat) > 1 and all(isinstance(one, str) for one in flat) else []


def _simulink(structure: Mapping[str, Any]) -> dict[str, Any]:
    """A structure with time of Simulink as series: each signal is called by its label, or by its number."""
    signals = structure["signals"]
    several = (
        [signals] if isinstance(signals, Mapping) else [s for s in np.atleast_1d(signals) if isinstance(s, Mapping)]
    )
    out: dict[str, Any] = {"time": structure["time"]}
    for number, signal in enumerate(several, start=1):
        labels = signal.get("label", "")
        label = labels if isinstance(labels, str) and labels.strip() else f"signal {number}"
        out |= _split(label, np.squeeze(np.asarray(signal.get("values", ()))), np.size(structure["time"]))
    return out


def _split(label: str, values: np.ndarray, size: int) -> dict[str, np.ndarray]:
    """The columns of a signal (N, k), called by the parts of a label with commas where it has as many."""
    if values.ndim != 2 or size not in values.shape:
        return {label: values}
    tall = values if values.shape[0] == size else values.T
    names = [part.strip() for part in label.split(",")]
    names = names if len(names) == tall.shape[1] else [f"{label} {i + 1}" for i in range(tall.shape[1])]
    return {name: tall[:, i].copy() for i, name in enumerate(names)}


def _column(name: str, unit: str, values: np.ndarray) -> RawColumn:
    """A column; a time since a moment that its unit states is one since 1970."""
    match = SINCE.fullmatch(unit.strip())
    start = moment(match["start"].strip()) if match else np.nan
    if match is None or not np.isfinite(start) or match["unit"].lower() not in SECONDS:
        return RawColumn(name, unit, values)
    seconds = start + SECONDS[match["unit"].lower()] * values
    return RawColumn(name, "s", seconds, "time", f"its unit states {unit}")


# ---- HDF5 files and MAT files of version 7.3, read by h5py.

MOST_ITEMS, MOST_DEPTH, MOST_BYTES, MOST_NAMES = 10_000, 12, 2**31, 2000
UNIT_ATTRIBUTES = ("units", "unit", "Units", "Unit", "UNIT", "einheit")


def hdf_content(data: bytes) -> tuple[dict[str, Any], dict[str, str]]:
    """(arrays and texts in nested dictionaries, path of an array -> its unit); links to other files are not followed.

    Raises
    ------
    BadInput : h5py is missing, or the file has too many groups.
    """
    with extras_told():
        import h5py

    units: dict[str, str] = {}
    with h5py.File(io.BytesIO(data), "r") as file:
        return _group(h5py, file, "", units, [0]), units


def _group(h5py: Any, group: Any, where: str, units: dict[str, str], count: list[int]) -> dict[str, Any]:
    out: dict[str, Any] = {str(name): value for name, value in group.attrs.items() if np.size(value) == 1}
    for name in group:
        count[0] += 1
        if count[0] > MOST_ITEMS or where.count(".") >= MOST_DEPTH:
            raise BadInput("an HDF5 file with too many or too deep groups")
        link = group.get(name, getlink=True)
        if isinstance(link, h5py.ExternalLink) or name.startswith("#"):
            continue
        item = group.get(name)
        if isinstance(item, h5py.Group):
            out[name] = _group(h5py, item, f"{where}.{name}".strip("."), units, count)
        elif isinstance(item, h5py.Dataset) and not item.is_virtual and not item.external and item.nbytes < MOST_BYTES:
            unit = next((text for key in UNIT_ATTRIBUTES if (text := text_of(item.attrs.get(key)))), "")
            units |= {f"{where}.{name}".strip("."): unit} if unit else {}
            if text_of(item.attrs.get("MATLAB_class")) == "char":
                out[name] = "".join(map(chr, np.asarray(item[()]).ravel(order="F").astype(int).tolist()))
            elif item.dtype.names:
                table = item[()]
                out[name] = {field: table[field] for field in item.dtype.names}
            elif item.dtype.kind in "fiub":
                out[name] = unpacked(np.asarray(item[()]), item.attrs)
            elif h5py.check_string_dtype(item.dtype) is not None and item.size <= MOST_NAMES:
                texts = np.array([text_of(one) for one in np.ravel(item[()])])
                out[name] = text_of(item[()]) if item.shape == () else texts
    return out


def unpacked(values: np.ndarray, stated: Mapping[str, Any]) -> np.ndarray:
    """The numbers of an array; packed ones by their attributes (Climate and Forecast conventions 1.11, section 8.1)."""
    packing = {name: stated[name] for name in ("scale_factor", "add_offset", "_FillValue") if name in stated}
    if not packing:
        return values
    numbers = {name: float(np.ravel(value)[0]) for name, value in packing.items()}
    real = values.astype(float) * numbers.get("scale_factor", 1.0) + numbers.get("add_offset", 0.0)
    return np.where(values == numbers["_FillValue"], np.nan, real) if "_FillValue" in numbers else real


def text_of(value: Any) -> str:
    """The text of an attribute; '' where it is none."""
    if isinstance(value, np.ndarray) and value.size == 1:
        value = value.ravel()[0]
    return value.decode("utf-8", "replace") if isinstance(value, bytes) else value if isinstance(value, str) else ""


# ---- Parquet and Arrow files, read by PyArrow.

MOST_CELLS = 200_000_000


def read_arrow(data: bytes, path: Path) -> list[RawTable]:
    """The table of a Parquet file or of one of Arrow's (Feather), with the units that its fields state; BadInput where
    it holds none, or too many."""
    with extras_told():
        import pyarrow as pa
        import pyarrow.parquet as pq

    source, parquet = pa.BufferReader(data), data.startswith(b"PAR1")
    file: Any = pq.ParquetFile(source) if parquet else pa.ipc.open_file(source)
    if parquet:
        rows, width = file.metadata.num_rows, file.metadata.num_columns
    else:
        rows, width = sum(file.get_batch(i).num_rows for i in range(file.num_record_batches)), len(file.schema)
    if rows * max(width, 1) > MOST_CELLS:
        raise BadInput(f"more than {MOST_CELLS:,} cells", file=path, hint="cut it into parts")
    table = file.read() if parquet else file.read_all()
    columns = [_of_field(field, table.column(i)) for i, field in enumerate(table.schema)]
    if all(column.known == "not used" for column in columns) or table.num_rows < 1:
        raise BadInput("no columns of numbers found", file=path)
    return [RawTable.of(path, columns, "Parquet" if parquet else "Arrow")]


def _of_field(field: Any, values: Any) -> RawColumn:
    """A field as numbers, moments as texts; one of another kind is not used."""
    import pyarrow as pa

    metadata, kind = field.metadata or {}, field.type
    unit = next((metadata[key].decode("utf-8", "replace") for key in (b"unit", b"units") if key in metadata), "")
    if pa.types.is_dictionary(kind):
        return _of_field(field.with_type(kind.value_type), values.cast(kind.value_type))
    if pa.types.is_timestamp(kind):
        values = values.cast(pa.timestamp("ns", "UTC" if kind.tz else None), safe=False).cast(pa.string())
    if pa.types.is_duration(kind):
        unit, values = "s", values.cast(pa.duration("ns"), safe=False).cast(pa.int64())
    if pa.types.is_string(values.type) or pa.types.is_large_string(values.type):
        return RawColumn(str(field.name), unit, tuple("" if v is None else v for v in values.to_pylist()))
    try:
        numbers = np.asarray(values.cast(pa.float64(), safe=False).to_numpy(zero_copy_only=False), dtype=float)
    except pa.ArrowException:
        numbers = np.full(len(values), np.nan)
        return RawColumn(
            str(field.name), unit, numbers, "not used", f"a Parquet column of type {kind}, which is not read"
        )
    return RawColumn(str(field.name), unit, 1e-9 * numbers if pa.types.is_duration(kind) else numbers)
