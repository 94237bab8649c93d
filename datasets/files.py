"""File access that readers and writers share: whole files are read, and complete files are written."""

from __future__ import annotations

import os
import secrets
from collections.abc import Callable, Iterable, Mapping
from pathlib import Path

from ..models.errors import BadInput


def read_bytes(path: Path) -> bytes:
    """The whole file; BadInput where it is missing or cannot be read."""
    try:
        return path.read_bytes()
    except FileNotFoundError:
        raise BadInput("no such file", file=path) from None
    except OSError as error:
        raise BadInput(f"cannot be read ({error.strerror or error})", file=path) from None


def read_utf8(path: Path) -> bytes:
    """The whole file without a byte order mark; BadInput with the row where it is not UTF-8 text."""
    data = read_bytes(path).removeprefix(b"\xef\xbb\xbf")
    wrong = _first_wrong_byte(data)
    if wrong is not None:
        message = f"wrong encoding: byte 0x{data[wrong]:02x} is not UTF-8 text"
        raise BadInput(message, file=path, row=_line_of(data, wrong), hint="save the file as UTF-8 text")
    return data


def _first_wrong_byte(data: bytes) -> int | None:
    try:
        if not data.isascii():
            data.decode("utf-8")
    except UnicodeDecodeError as error:
        return error.start
    zero = data.find(0)
    return zero if zero >= 0 else None


def _line_of(data: bytes, position: int) -> int:
    before = data[:position]
    return before.count(b"\n") + before.count(b"\r") - before.count(b"\r\n") + 1


def refuse_existing(paths: Iterable[Path]) -> None:
    """BadInput if one of the files exists."""
    for path in paths:
        if path.exists():
            raise BadInput(
                "exists already", file=path, hint="give another place, or --force (force=True) to replace it"
            )


def replace_together(writers: Mapping[Path, Callable[[Path], object]]) -> None:
    """Write every file under a temporary name beside its place, then move each there in one step.

    `writers` maps a place to a function that writes the file under the name it is given. On any failure nothing
    remains of the temporary files; BadInput where a place cannot be written to.
    """
    temporary = {path: path.with_name(f".{path.name}.{secrets.token_hex(4)}.tmp") for path in writers}
    current = next(iter(writers))
    try:
        for current, write in writers.items():
            if current.is_dir():
                raise IsADirectoryError(None, "is a directory")
            write(temporary[current])
        for current in writers:
            os.replace(temporary[current], current)
    except OSError as error:
        raise BadInput(f"cannot be written ({error.strerror or error})", file=current) from None
    finally:
        for path in temporary.values():
            path.unlink(missing_ok=True)
