"""Files in a folder that exists already: it may come from elsewhere and hold links, pipes and files of other users.

Every file of such a folder is opened, written or removed here.  Only regular files are, never what a link names, and
only in folders of this user; everything is checked before anything is written.
"""

from __future__ import annotations

import errno
import os
import stat
import sys
from collections.abc import Generator, Iterable
from contextlib import contextmanager
from pathlib import Path

from .errors import BadInput
from .files import reason_of
from .temporary import is_mine, temporary_file

ADMINISTRATOR = 0
"""Number of the user whose folders and files are trusted as the own ones."""
_SAFE = sum(getattr(os, name, 0) for name in ("O_NOFOLLOW", "O_NONBLOCK", "O_CLOEXEC", "O_BINARY"))
"""Flags of every opening: links are not followed, pipes are not waited for."""
MOST_BYTES = 2**34
"""Largest journal that is read: some millions of runs."""


def is_own(found: os.stat_result) -> bool:
    """Whether a file or folder belongs to this user or the administrator; true where files have no owners."""
    return is_mine(found) or found.st_uid == ADMINISTRATOR


def check_folder(folder: Path) -> None:
    """BadInput where something exists that is no folder, or one of another user; a folder may be named by a link."""
    try:
        found = folder.stat()
    except FileNotFoundError:
        if folder.is_symlink():
            raise BadInput("is a link to nothing", file=folder, hint="give a new directory") from None
        return
    except OSError as error:
        raise BadInput(f"cannot be used ({reason_of(error)})", file=folder) from None
    if not stat.S_ISDIR(found.st_mode):
        raise BadInput("is not a directory", file=folder, hint="give a new directory with -o")
    if not is_own(found):
        raise BadInput("belongs to another user", file=folder, hint="copy what is in it to a folder of your own")


def make_folder(folder: Path, within: Path | None = None) -> Path:
    """A folder that is made where it is missing, and checked where it exists; it.

    within : folder above it below which nothing may be a link.
    """
    inner = [] if within is None else [folder, *folder.parents][: len(folder.relative_to(within).parts)]
    for part in inner:
        if part.is_symlink():
            raise BadInput("is a link", file=part, hint="folders of results hold no links: remove it")
    check_folder(folder)
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise BadInput(f"cannot be made ({reason_of(error)})", file=folder) from None
    return folder


def check_regular(path: Path) -> bool:
    """Whether a file exists; BadInput where it is a link, a pipe, a folder or a device."""
    try:
        mode = path.lstat().st_mode
    except (FileNotFoundError, NotADirectoryError):
        return False
    if not stat.S_ISREG(mode):
        kind = "link" if stat.S_ISLNK(mode) else "directory" if stat.S_ISDIR(mode) else "pipe or a device"
        raise BadInput(f"is a {kind}, not a file", file=path, hint="remove it, or copy the files to a new directory")
    return True


def path_within(folder: Path, name: str, file: object, key: str = "") -> Path:
    """The path of a file that another file names, in `folder` or below it.

    Every name that comes from a file of somebody else and is opened goes through here.  A hard link is the file itself
    and cannot be refused: whoever made it could write to the folder.

    file, key : where the name stands, for the message.

    Raises
    ------
    BadInput : an absolute path of any system, a drive, a backslash, a way out (`..`), or a link on the way.
    """
    told, parts = f"{key}: {name[:120]!r}".removeprefix(": "), name.split("/")
    if any(not part.strip(" .") for part in parts) or not name.isprintable() or set(name) & set("\\:"):
        hint = "name a file in its folder or below it, without '..', drive or backslash"
        raise BadInput(f"{told} is outside its folder", file=file, hint=hint)
    path = folder
    try:
        for part in parts:
            path = path / part
            if path.is_symlink():
                raise BadInput(f"{told} is reached by a link", file=file, hint="put the file itself there")
        inside = path.resolve().is_relative_to(folder.resolve())
    except (OSError, RuntimeError) as error:
        raise BadInput(f"{told} cannot be used ({reason_of(error)})", file=file) from None
    if not inside:
        raise BadInput(f"{told} is outside its folder", file=file, hint="put the file itself there")
    return path


def read_regular(path: Path, most: int = MOST_BYTES) -> bytes:
    """The content of a file; empty where it is missing.  BadInput where it is no regular file, or is larger than
    `most` bytes."""
    if not check_regular(path):
        return b""
    with _told(path), os.fdopen(open_regular(path, os.O_RDONLY), "rb") as file:
        size = os.fstat(file.fileno()).st_size
        if size > most:
            told = f"{most // 2**30} GiB" if most >= 2**30 else f"{most // 2**10} KiB"
            raise BadInput(f"is larger than {told}, the most that is read", file=path)
        return file.read(size)


def open_to_append(path: Path) -> int:
    """Open a regular file of this user with one name, made where it is missing, for reading and appending."""
    check_regular(path)
    with _told(path):
        return _writable(path, os.O_RDWR | os.O_CREAT | os.O_APPEND)


def write_all(file: int, data: bytes, path: Path) -> None:
    """Write everything to an open file; BadInput, which names the file, where the disk is full."""
    with _told(path):
        while data:
            data = data[os.write(file, data) :]


def write_atomic(path: Path, data: bytes, mode: int = 0o644) -> None:
    """Write a file whole or not at all; a link is replaced, not what it names.  BadInput where it cannot be.

    mode : permissions with which it is made, less what the umask takes.
    """
    with _told(path), temporary_file(path.parent, mode) as temporary:
        with os.fdopen(_writable(temporary, os.O_WRONLY), "wb") as stream:
            stream.write(data)
        os.replace(temporary, path)


def check_each(folder: Path, appended: Iterable[str], replaced: Iterable[str]) -> None:
    """BadInput where a folder or one of the files that will be appended to or replaced in it must not be written."""
    check_folder(folder)
    for path in (folder / name for name in appended):
        if check_regular(path):
            with _told(path):
                os.close(_writable(path, os.O_RDONLY))
    for name in replaced:
        check_regular(folder / name)


def open_regular(path: Path, flags: int) -> int:
    """Open a regular file, never what a link names.  Raises `OSError`, and BadInput where it is a pipe or the like."""
    file = os.open(path, flags | _SAFE, 0o644)
    if stat.S_ISREG(os.fstat(file).st_mode):
        return file
    os.close(file)
    raise BadInput("is not a file", file=path)


def _writable(path: Path, flags: int) -> int:
    """Open a regular file of this user that has one name."""
    file = open_regular(path, flags)
    found = os.fstat(file)
    if is_own(found) and found.st_nlink == 1:
        return file
    os.close(file)
    told = "has more than one name (hard links)" if is_own(found) else "belongs to another user"
    raise BadInput(told, file=path, hint="copy the files to a new directory")


@contextmanager
def _told(path: Path) -> Generator[None]:
    """What the system refuses is told with the name of the file."""
    try:
        yield
    except OSError as error:
        told = "is a link, not a file" if error.errno == errno.ELOOP else f"cannot be used ({reason_of(error)})"
        raise BadInput(told, file=path) from None


# ---- Nothing is imported from the working folder: files of others may lie there, a `threading.py` among them.

VARIABLE = "PYTHONSAFEPATH"
"""Variable of the environment with which Python leaves the working folder off the path of modules."""


@contextmanager
def without_working_folder() -> Generator[None]:
    """Neither this process nor one that it starts imports from the working folder in the enclosed code.

    The empty entry of `sys.path`, which stands for the working folder in an interactive session, is taken out:
    multiprocessing and joblib hand their workers this path.  Folders that the path names stay.
    """
    variable, empty = os.environ.get(VARIABLE), [place for place, entry in enumerate(sys.path) if not entry]
    os.environ[VARIABLE] = "1"
    sys.path[:] = filter(None, sys.path)
    try:
        yield
    finally:
        for place in empty:
            sys.path.insert(place, "")
        if variable is None:
            os.environ.pop(VARIABLE, None)
        else:
            os.environ[VARIABLE] = variable
