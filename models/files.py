"""File access that readers and writers share: whole files are read, and complete files are written."""

from __future__ import annotations

import os
import re
import stat
from collections.abc import Callable, Iterable, Mapping
from contextlib import ExitStack
from pathlib import Path

from .errors import BadInput
from .temporary import temporary_file

MOST_BYTES = 2**30
"""Largest file that is read, 1 GiB: a record of about ten million samples."""


def read_bytes(path: Path, most: int = MOST_BYTES) -> bytes:
    """The whole file of at most `most` bytes; BadInput where it is missing, larger or cannot be read."""
    refuse_undecodable(path)
    try:
        with path.open("rb") as file:
            found = os.fstat(file.fileno())
            if not (stat.S_ISREG(found.st_mode) or stat.S_ISFIFO(found.st_mode)):  # reading of others may never end
                raise BadInput("is not a file of data", file=path)
            data = file.read(min(found.st_size or most, most) + 1)
    except FileNotFoundError:
        raise BadInput("no such file", file=path) from None
    except BadInput:
        raise
    except (OSError, ValueError) as error:
        raise BadInput(f"cannot be read ({reason_of(error)})", file=path) from None
    if len(data) > most:
        raise BadInput(f"is larger than {most // 2**10} KiB, the most that is read", file=path)
    return data


def read_utf8(path: Path, most: int = MOST_BYTES) -> bytes:
    """The whole file without a byte order mark; BadInput with the row where it is not UTF-8 text."""
    return utf8_of(read_bytes(path, most), path)


def utf8_of(data: bytes, path: Path) -> bytes:
    """The content of a file without a byte order mark; BadInput with the row where it is not UTF-8 text."""
    data = data.removeprefix(b"\xef\xbb\xbf")
    wrong = _first_wrong_byte(data)
    if wrong is not None:
        message = f"wrong encoding: byte 0x{data[wrong]:02x} is not UTF-8 text"
        row = 1 + len(re.findall(b"\r\n|\r|\n", data[:wrong]))
        raise BadInput(message, file=path, row=row, hint="save the file as UTF-8 text")
    return data


def refuse_undecodable(path: Path) -> None:
    """Refuse a file whose name is not UTF-8 text: it could not be named in any result."""
    if not os.fspath(path).isascii():
        try:
            os.fspath(path).encode()
        except UnicodeEncodeError:
            raise BadInput("the name of the file is not UTF-8 text", file=path, hint="rename the file") from None


def reason_of(error: Exception) -> str:
    """Why the system refused a file, in words."""
    return (error.strerror if isinstance(error, OSError) else None) or str(error)


def _first_wrong_byte(data: bytes) -> int | None:
    try:
        if not data.isascii():
            data.decode("utf-8")
    except UnicodeDecodeError as error:
        return error.start
    zero = data.find(0)
    return zero if zero >= 0 else None


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
    temporary: dict[Path, Path] = {}
    current = next(iter(writers))
    try:
        with ExitStack() as stack:
            for current, write in writers.items():
                refuse_place(current)
                temporary[current] = stack.enter_context(temporary_file(current.parent))
                write(temporary[current])
            for current in writers:
                os.replace(temporary[current], current)
    except OSError as error:
        raise BadInput(f"cannot be written ({reason_of(error)})", file=current) from None


def refuse_place(path: Path) -> None:
    """Refuse to replace what is not a file: a folder, a device, a pipe; and a name that is not UTF-8 text."""
    refuse_undecodable(path)
    if path.is_dir():
        raise BadInput("cannot be written (is a directory)", file=path, hint="give the name of a file")
    if path.exists() and not path.is_file():
        raise BadInput("cannot be written (it is a device or a pipe)", file=path, hint="give the name of a file")


def write_together(folder: Path, writers: Mapping[str, Callable[[Path], object]]) -> tuple[Path, ...]:
    """Write files of a folder, which is made if need be: all of them or none.

    writers : name of the file -> function that writes it to a path.

    Raises
    ------
    BadInput : the folder cannot be made or written to.
    """
    created = not folder.exists()
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise BadInput(f"cannot be made ({reason_of(error)})", file=folder) from None
    try:
        replace_together({folder / name: write for name, write in writers.items()})
    except BaseException:
        if created:
            folder.rmdir()
        raise
    return tuple(folder / name for name in writers)


def content_writer(content: str | bytes) -> Callable[[Path], object]:
    """A function that writes the content to a path, text as UTF-8."""

    def write(place: Path) -> None:
        place.write_bytes(content.encode() if isinstance(content, str) else content)

    return write
