"""Parquet files, read by PyArrow."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from ....models.errors import BadInput
from ....models.extras import extras_told
from ..raw import RawColumn, RawTable

MOST_CELLS = 200_000_000


def read_parquet(data: bytes, path: Path) -> list[RawTable]:
    """The table of a Parquet file, with the units that its fields state; BadInput where it holds none, or too many."""
    with extras_told():
        import pyarrow as pa
        import pyarrow.parquet as pq

    file = pq.ParquetFile(pa.BufferReader(data))
    if file.metadata.num_rows * max(file.metadata.num_columns, 1) > MOST_CELLS:
        raise BadInput(f"more than {MOST_CELLS:,} cells", file=path, hint="cut it into parts")
    table = file.read()
    columns = [_column(field, table.column(i)) for i, field in enumerate(table.schema)]
    if all(column.known == "not used" for column in columns) or table.num_rows < 1:
        raise BadInput("no columns of numbers found", file=path)
    return [RawTable.of(path, columns, "Parquet")]


def _column(field: Any, values: Any) -> RawColumn:
    import pyarrow as pa

    metadata = field.metadata or {}
    unit = next((metadata[key].decode("utf-8", "replace") for key in (b"unit", b"units") if key in metadata), "")
    kind = field.type
    if pa.types.is_timestamp(kind):
        moments = values.cast(pa.timestamp("ns", tz=kind.tz), safe=False).to_numpy(zero_copy_only=False)
        texts = tuple(
            "" if np.isnat(m) else f"{np.datetime_as_string(m)}{'Z' if kind.tz else ''}"
            for m in moments.astype("datetime64[ns]")
        )
        return RawColumn(str(field.name), unit, texts)
    if pa.types.is_dictionary(kind):
        return _column(field.with_type(kind.value_type), values.cast(kind.value_type))
    if pa.types.is_duration(kind):
        spans = values.cast(pa.duration("ns"), safe=False).cast(pa.int64()).cast(pa.float64(), safe=False)
        return RawColumn(str(field.name), "s", 1e-9 * np.asarray(spans.to_numpy(zero_copy_only=False), dtype=float))
    if any(
        is_kind(kind)
        for is_kind in (pa.types.is_integer, pa.types.is_floating, pa.types.is_boolean, pa.types.is_decimal)
    ):
        numbers = values.cast(pa.float64(), safe=False).to_numpy(zero_copy_only=False)
        return RawColumn(str(field.name), unit, np.asarray(numbers, dtype=float))
    if pa.types.is_string(kind) or pa.types.is_large_string(kind):
        return RawColumn(str(field.name), unit, tuple("" if v is None else v for v in values.to_pylist()))
    empty = np.full(len(values), np.nan)
    return RawColumn(str(field.name), unit, empty, "not used", f"a Parquet column of type {kind}, which is not read")
