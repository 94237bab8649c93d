"""Any raw log as raw tables: the kind of a file is told by its content."""

from __future__ import annotations

import os
from dataclasses import replace
from pathlib import Path

from ...models.errors import BadInput
from ...models.files import read_bytes
from .beside import with_sidecar
from .contained import read_contained
from .nmea import looks_like_nmea, read_nmea
from .raw import RawTable
from .text import decoded, read_text

REFUSED = {
    b"\xd0\xcf\x11\xe0": ("an Excel file of the old form (xls)", "save it as xlsx or CSV"),
    b"PAR1": ("a Parquet file", "records in Parquet need no import; other tables: save them as CSV"),
    b"\x1f\x8b": ("a compressed file", "unpack it first"),
    b"%PDF": ("a PDF", "export the log as CSV"),
}


def read_raw(path: str | os.PathLike[str]) -> list[RawTable]:
    """The raw tables of a file, one or more.

    Raises
    ------
    BadInput : the file cannot be read, or holds no table of a kind that is known.
    """
    path = Path(path)
    if path.is_dir():
        raise BadInput("is a directory", file=path, hint="name the log files in it")
    data = read_bytes(path)
    if not data.strip():
        raise BadInput("the file is empty", file=path)
    for magic, (what, hint) in REFUSED.items():
        if data.startswith(magic):
            raise BadInput(what, file=path, hint=hint)
    return with_sidecar([replace(table, clock=str(path)) for table in _tables(data, path)], path)


def _tables(data: bytes, path: Path) -> list[RawTable]:
    kind = _binary_kind(data)
    if kind is not None:
        return read_contained(kind, data, path)
    text, encoding = decoded(data, path)
    return read_nmea(text, path) if looks_like_nmea(text) else [read_text(text, encoding, path)]


def _binary_kind(data: bytes) -> str | None:
    if data.startswith(b"PK"):
        return "a workbook"
    return "a MAT file" if data.startswith((b"MATLAB", b"\x89HDF")) else None
