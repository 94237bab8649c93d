"""Columns of numbers in CSV by Arrow, where it is installed: tens of times as fast, and the same numbers and texts.

Nothing here decides what is a number: whatever is not plain is left to the readers and writers that look at each cell.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

FEWEST_BYTES = 200_000
"""Size of a file from which on it pays to import Arrow."""
FEWEST_ROWS = 5000
"""Rows from which on it pays to write them by Arrow."""
SAME_TEXTS = (1e-4, 1e10)
"""Sizes between which, zero aside, Arrow and Python write a number in the same way."""


def arrow() -> Any:
    """The module `pyarrow` with `compute` and `csv`; None where it is not installed."""
    try:
        import pyarrow
        import pyarrow.compute
        import pyarrow.csv
    except ImportError:
        return None
    return pyarrow


def compute() -> Any:
    """Arrow's functions of arrays, made when it is loaded: no checker of types knows them."""
    from pyarrow import compute

    return compute


def columns_of_numbers(body: bytes, names: list[str], delimiter: str) -> dict[str, np.ndarray] | None:
    """Name -> numbers (N,) of CSV without its header, gaps nan; None where a cell is no plain number or gap, a row has
    another length, or Arrow is not installed.

    Cells in quotes, lines that end with a carriage return alone, and brackets (`nan(1)`, which Arrow takes) are not
    plain.
    """
    if b'"' in body or b"(" in body or (b"\r" in body and body.count(b"\r") != body.count(b"\r\n")):
        return None
    pa = arrow()
    if pa is None:
        return None
    kinds = pa.csv.ConvertOptions(
        column_types=dict.fromkeys(names, pa.float64()), null_values=[""], strings_can_be_null=True
    )
    try:
        table = pa.csv.read_csv(
            pa.BufferReader(body),
            read_options=pa.csv.ReadOptions(column_names=names),
            parse_options=pa.csv.ParseOptions(delimiter=delimiter, quote_char=False),
            convert_options=kinds,
        )
    except pa.ArrowException:
        return None
    return {name: numbers_of_arrow(table.column(name).combine_chunks()) for name in names}


def numbers_of_arrow(column: Any) -> np.ndarray:
    """The numbers (N,) of an array of doubles, nan at gaps; its own `to_numpy` would import pandas, which takes
    longer than a record to read."""
    return np.from_dlpack(column.fill_null(np.nan) if column.null_count else column)


def arrow_numbers(values: np.ndarray) -> Any:
    """Numbers (N,) as an array of Arrow's; `pyarrow.array` would import pandas, here and below."""
    import pyarrow as pa

    given = np.ascontiguousarray(values, dtype=np.float64)
    return pa.Array.from_buffers(pa.float64(), given.size, [None, pa.py_buffer(given)])


def arrow_mask(values: np.ndarray) -> Any:
    """Truth values (N,) as an array of Arrow's."""
    import pyarrow as pa

    given = np.ascontiguousarray(values).view(np.uint8)
    return pa.Array.from_buffers(pa.uint8(), given.size, [None, pa.py_buffer(given)]).cast(pa.bool_())


def arrow_texts(texts: Sequence[str]) -> Any:
    """Texts (N) as an array of Arrow's."""
    import pyarrow as pa

    cells = [text.encode() for text in texts]
    ends = np.cumsum([0, *map(len, cells)], dtype=np.int32)
    return pa.StringArray.from_buffers(len(cells), pa.py_buffer(ends), pa.py_buffer(b"".join(cells)))


def mask_of_arrow(found: Any) -> np.ndarray:
    """(N,) truth values of an array of Arrow's; null is false."""
    return np.from_dlpack(found.fill_null(False).cast("uint8")).view(bool)


def write_csv(columns: Mapping[str, np.ndarray], path: Path) -> bool:
    """Write columns (N,) of finite numbers and gaps (nan), each number as the shortest text that reads back as the
    same; whether it was done: not without Arrow."""
    pa = arrow()
    if pa is None:
        return False
    texts = pa.table({name: _texts(pa, values) for name, values in columns.items()})
    plain = pa.csv.WriteOptions(include_header=False, quoting_style="none")
    with path.open("wb") as file:
        file.write(f"{','.join(columns)}\n".encode())
        pa.csv.write_csv(texts, file, plain)
    return True


def _texts(pa: Any, values: np.ndarray) -> Any:
    """Texts (N,) of numbers, null for nan, as `short_text` writes them."""
    size, known = np.abs(values), ~np.isnan(values)
    rest = known & (size != 0.0) & ~((size >= SAME_TEXTS[0]) & (size < SAME_TEXTS[1]))
    texts = pa.compute.if_else(arrow_mask(known), arrow_numbers(values).cast(pa.string()), None)
    own = arrow_texts([short_text(value) for value in values[rest].tolist()])
    return pa.compute.replace_with_mask(texts, arrow_mask(rest), own)


def short_text(value: float) -> str:
    """The shortest decimals that read back as the same float64; nothing for nan."""
    return "" if value != value else repr(value).removesuffix(".0")
