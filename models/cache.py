"""The folder of compiled code: private to the user, every file checked by its digest before it is used.

What is kept there is run, so nobody else may write it.  A file that is damaged, that belongs to another user or that
others may write counts as missing and is built again.
"""

from __future__ import annotations

import atexit
import hashlib
import os
import stat
import sys
import tempfile
import time
import warnings
from collections.abc import Callable, Generator
from contextlib import ExitStack, contextmanager
from functools import lru_cache
from pathlib import Path

from .errors import BadInput, EnvironmentFault
from .files import reason_of
from .folders import is_own, open_regular
from .temporary import is_mine, temporary_file, temporary_folder

VARIABLE = "HELMBENCH_CACHE"
LOCK_WAIT_S = 600.0
"""How long one process waits for another that builds the same code; then it builds its own."""


class Clock:
    """Seconds that this process has spent on building code or on waiting for another that builds it."""

    def __init__(self) -> None:
        self._past, self._depth, self._since = 0.0, 0, 0.0

    def seconds(self) -> float:
        """Seconds until now."""
        return self._past + (time.monotonic() - self._since if self._depth else 0.0)

    @contextmanager
    def running(self) -> Generator[None]:
        """The enclosed code builds."""
        if not self._depth:
            self._since = time.monotonic()
        self._depth += 1
        try:
            yield
        finally:
            self._depth -= 1
            if not self._depth:
                self._past += time.monotonic() - self._since


BUILDING = Clock()
COMPILING = "compiling the code of models and methods: once on this machine, up to half a minute"


class FirstUse:
    """Says that code is compiled where a user waits for it: at its first use."""

    def __init__(self) -> None:
        self._listener: Callable[[str], object] = _printed
        self._said = False

    def begins(self) -> None:
        """A function is compiled; said once."""
        if not self._said:
            self._said = True
            self._listener(COMPILING)

    @contextmanager
    def told_to(self, listener: Callable[[str], object]) -> Generator[None]:
        """Say it to `listener` in the enclosed code, once more if it was said before."""
        former, self._listener, self._said = self._listener, listener, False
        try:
            yield
        finally:
            self._listener = former


def _printed(text: str) -> None:
    """A line for people: on a terminal or in a notebook."""
    if sys.stderr.isatty() or "ipykernel" in sys.modules:
        print(f"helmbench: {text}", file=sys.stderr, flush=True)


FIRST_USE = FirstUse()
DIGEST_BYTES = hashlib.sha256().digest_size


@lru_cache
def cache_folder() -> Path:
    """Folder of compiled code: HELMBENCH_CACHE, else the user's cache, else one that lasts as long as this process.

    Workers started later share the folder: a passing one is put into the environment.

    Raises
    ------
    EnvironmentFault : HELMBENCH_CACHE names a folder that cannot be used, or not even a temporary one can be made.
    """
    from platformdirs import user_cache_path

    hint = f"set {VARIABLE} to a folder of your own that can be written"
    if named := os.environ.get(VARIABLE):
        try:
            return private_folder(Path(named)) / "kernels"
        except OSError as error:
            raise EnvironmentFault(
                f"compiled code cannot be kept here ({reason_of(error)})", file=named, hint=hint
            ) from None
    home = user_cache_path("helmbench")
    try:
        return private_folder(home) / "kernels"
    except OSError as error:
        reason = (
            f"{home}: compiled code cannot be kept here ({reason_of(error)}) and is built anew at every start; {hint}"
        )
    warnings.warn(reason, RuntimeWarning, stacklevel=2)
    return _passing_folder(hint) / "kernels"


def _passing_folder(hint: str) -> Path:
    """A new private folder that is removed when this process ends."""
    stack = ExitStack()
    try:
        folder = stack.enter_context(temporary_folder())
    except OSError as error:
        raise EnvironmentFault(f"no folder for compiled code can be made ({reason_of(error)})", hint=hint) from None
    os.environ[VARIABLE] = str(folder)
    owner = os.getpid()
    atexit.register(lambda: os.getpid() == owner and stack.close())
    return private_folder(folder)


def private_folder(folder: Path) -> Path:
    """The folder, with a subfolder `kernels` that only this user can enter; both are made where they are missing.

    The permissions of a folder that exists are left alone, those of `kernels` are closed.
    Raises `OSError` where the folder is a link, belongs to another user (but the administrator) or cannot be written.
    """
    if not is_own(_made(folder)):
        raise OSError(f"{folder} belongs to another user")
    close_folder(folder / "kernels")
    tempfile.TemporaryFile(dir=folder / "kernels").close()
    return folder


def close_folder(folder: Path) -> None:
    """Make a folder that only this user can enter, or close one of this user's; `OSError` where it is another's."""
    found = _made(folder)
    if not is_mine(found):
        raise OSError(f"{folder} belongs to another user")
    if hasattr(os, "geteuid") and found.st_mode & 0o077:
        folder.chmod(stat.S_IMODE(found.st_mode) & ~0o077)


def _made(folder: Path) -> os.stat_result:
    """What a folder is, which is made where it is missing; `OSError` where it is a link or a file."""
    folder.mkdir(mode=0o700, parents=True, exist_ok=True)
    found = folder.lstat()
    if not stat.S_ISDIR(found.st_mode):
        raise OSError(f"{folder} is a link or a file")
    return found


def store(path: Path, data: bytes) -> None:
    """Write a file with its digest in front, whole or not at all.  Raises `OSError`."""
    with temporary_file(path.parent, 0o600) as temporary:
        temporary.write_bytes(hashlib.sha256(data).digest() + data)
        os.replace(temporary, path)


def stored(path: Path) -> bytes | None:
    """What `store` wrote; None where there is nothing, or where it is damaged or can be another user's work."""
    try:
        with os.fdopen(open_regular(path, os.O_RDONLY), "rb") as file:
            found = os.fstat(file.fileno())
            content = file.read() if is_mine(found) and not found.st_mode & 0o022 else b""
    except (OSError, BadInput):
        return None
    digest, data = content[:DIGEST_BYTES], content[DIGEST_BYTES:]
    return data if hashlib.sha256(data).digest() == digest else None


@contextmanager
def building(path: Path) -> Generator[None]:
    """While one process builds a file of the cache, others that need it wait here."""
    with BUILDING.running():
        lock = lock_of(path)
        try:
            yield
        finally:
            if lock is not None:
                lock.release()


def lock_of(path: Path):
    """The taken lock of a file; None where the file system has none or another process holds it for too long."""
    from filelock import FileLock

    lock = FileLock(f"{path}.lock", timeout=LOCK_WAIT_S, mode=0o600)
    try:
        lock.acquire()
    except (OSError, NotImplementedError):  # waiting for too long is an OSError too
        return None
    return lock
