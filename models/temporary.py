"""Temporary files and folders.  Each is locked by the process that uses it; the system gives the lock back when that
process ends, however it ends.  So what a killed command left is known and removed, and never what is in use.

The lock is advisory (`flock`).  Where there is none, on Windows or on some network disks, nothing is removed.
"""

from __future__ import annotations

import os
import secrets
import shutil
import stat
import tempfile
from collections.abc import Callable, Generator
from contextlib import AbstractContextManager, contextmanager, suppress
from functools import cache
from pathlib import Path

PATTERN = ".helmbench-*.tmp"
"""Pattern of the names of all temporary files and folders."""


def temporary_file(folder: Path, mode: int = 0o666) -> AbstractContextManager[Path]:
    """A new empty file in a folder, to be written and moved to its place; else it is removed at the end.

    mode : its permissions, less those that the user's mask takes away.

    Raises
    ------
    OSError : it cannot be made.
    """

    def make(path: Path) -> None:
        os.close(os.open(path, os.O_WRONLY | os.O_CREAT | os.O_EXCL, mode))

    return _held(folder, make, lambda path: path.unlink(missing_ok=True))


def temporary_folder(parent: Path | None = None, mode: int = 0o700) -> AbstractContextManager[Path]:
    """A new folder in another one, or in the system's folder of temporary files, with `mode`; as `temporary_file`."""
    place = parent or Path(tempfile.gettempdir())
    return _held(place, lambda path: path.mkdir(mode), lambda path: shutil.rmtree(path, ignore_errors=True))


def leftovers(folder: Path) -> list[Path]:
    """Temporary files and folders of this user in a folder, in use or not."""
    return [path for path in folder.glob(PATTERN) if _is_own(path)]


def remove_leftovers(folder: Path) -> None:
    """Remove the temporary files and folders of this user in a folder that no process uses."""
    for path in leftovers(folder):
        with suppress(OSError):
            file = _locked(path)
            try:
                shutil.rmtree(path, ignore_errors=True) if path.is_dir() else path.unlink()
            finally:
                os.close(file)


@cache
def _once(folder: Path) -> None:
    """`remove_leftovers` at the first use of a folder by this process."""
    remove_leftovers(folder)


@contextmanager
def _held(folder: Path, make: Callable[[Path], object], remove: Callable[[Path], object]) -> Generator[Path]:
    """A new name in a folder, made and locked, and removed at the end."""
    _once(folder.absolute())
    path, file = _made(folder, make)
    try:
        yield path
    finally:
        try:
            remove(path)
        finally:
            if file is not None:
                os.close(file)


def _made(folder: Path, make: Callable[[Path], object]) -> tuple[Path, int | None]:
    """A new name that was made, and its lock; None where there are no locks."""
    while True:
        path = folder / PATTERN.replace("*", secrets.token_hex(8))
        make(path)
        try:
            return path, _locked(path)
        except (BlockingIOError, FileNotFoundError):  # another process took it for a leftover just now
            continue
        except OSError:
            return path, None


def _locked(path: Path) -> int:
    """Open and lock a file or folder.

    Raises
    ------
    BlockingIOError : another process holds it.
    OSError : it is a link, or there are no locks.
    """
    try:
        import fcntl
    except ImportError:
        raise OSError("this system has no locks of files") from None
    way = os.O_RDONLY if path.is_dir() else os.O_RDWR
    file = os.open(path, way | os.O_NOFOLLOW | os.O_NONBLOCK)
    try:
        fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
        if not os.path.samestat(os.fstat(file), path.lstat()):
            raise FileNotFoundError(path)
    except BaseException:
        os.close(file)
        raise
    return file


def _is_own(path: Path) -> bool:
    """Whether it is a file or folder of this user, and no link."""
    try:
        found = path.lstat()
    except OSError:
        return False
    return is_mine(found) and (stat.S_ISREG(found.st_mode) or stat.S_ISDIR(found.st_mode))


def is_mine(found: os.stat_result) -> bool:
    """Whether a file or folder belongs to this user; true where files have no owners."""
    return not hasattr(os, "geteuid") or found.st_uid == os.geteuid()
