"""Readers of binary logs in a process of their own, with limits of memory and time: no file can bring down or fill
this one.

`python -P -m helmbench.datasets.importing.contained KIND FILE SECONDS BYTES` reads the file's bytes from its standard
input and writes what the reader returns, or why it cannot, to its standard output.
"""

from __future__ import annotations

import io
import os
import pickle
import signal
import subprocess
import sys
from contextlib import suppress
from dataclasses import is_dataclass
from pathlib import Path
from typing import Any

from ...models.errors import BadInput
from .binary_tables import read_arrow, read_excel, read_mat, read_netcdf
from .formats.autopilots import read_ardupilot, read_px4
from .formats.ros import read_bag
from .raw import RawTable

READERS = {
    "a workbook": read_excel,
    "a MAT file": read_mat,
    "an HDF5 file": read_mat,
    "a netCDF file": read_netcdf,
    "a Parquet file": read_arrow,
    "an Arrow file": read_arrow,
    "a PX4 log": read_px4,
    "an ArduPilot log": read_ardupilot,
    "a ROS bag": lambda _, path: read_bag(path),
}
"""Kind of a file -> its reader, of the content and the path; a bag may be a folder.  What their libraries raise on
damaged files is told by `answer`."""
MOST_BYTES = 2 * 2**30
"""Memory that a reader may take."""
LEAST_S, PER_MIB_S = 8.0, 4.0
"""CPU time that a reader may take, for a small file and more for every MiB."""
WAIT = 8.0
"""How much longer than its CPU time a reader is waited for: other processes take theirs."""
OUT_OF_MEMORY = 9
EXPORT = "export it as CSV"
SAVE_AGAIN = {"a workbook": "open it in the spreadsheet program and save it as xlsx again"}
"""What to do about a damaged file of a kind, where it is not to export it."""
_PLAIN = {
    ("pathlib", "PosixPath"), ("pathlib", "WindowsPath"), ("numpy", "ndarray"), ("numpy", "dtype"),
    *((f"numpy.{core}.{module}", name) for core in ("core", "_core")
      for module, name in (("multiarray", "_reconstruct"), ("numeric", "_frombuffer"), ("multiarray", "scalar"))),
    (BadInput.__module__, "BadInput"), (BadInput.__module__, "_rebuild"),
}  # fmt: skip


def read_contained(kind: str, data: bytes, path: Path) -> list[RawTable]:
    """The tables of a binary log.

    kind : of `READERS`.

    Raises
    ------
    BadInput : the file holds no table, is damaged, or takes too much memory or time to read.
    """
    seconds = LEAST_S + PER_MIB_S * len(data) / 2**20
    limits = (f"{seconds:.0f}", f"{MOST_BYTES}")
    command = [sys.executable, "-P", "-W", "ignore", "-m", __name__, kind, os.fspath(path), *limits]
    threads = dict.fromkeys(("OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS", "MKL_NUM_THREADS"), "1")
    try:
        done = subprocess.run(
            command, input=data, capture_output=True, timeout=WAIT * seconds, env={**os.environ, **threads}
        )
    except subprocess.TimeoutExpired:
        raise _too_much(kind, path, f"{WAIT * seconds:.0f} s") from None
    if done.returncode:
        raise _ended(kind, path, done.returncode, seconds)
    found = _Plain(io.BytesIO(done.stdout)).load()
    if isinstance(found, BadInput):
        raise found
    return found


def _ended(kind: str, path: Path, status: int, seconds: float) -> BadInput:
    """Why a reader ended without a result."""
    if status == OUT_OF_MEMORY or status == -signal.SIGKILL:
        return _too_much(kind, path, f"{MOST_BYTES / 2**30:.2g} GiB of memory")
    if status == -getattr(signal, "SIGXCPU", 0):
        return _too_much(kind, path, f"{seconds:.0f} s")
    return BadInput(f"not {kind} that can be read (its reader ended by it)", file=path, hint=f"is it whole? {EXPORT}")


def _too_much(kind: str, path: Path, what: str) -> BadInput:
    return BadInput(f"{kind} that takes more than {what} to read", file=path, hint=EXPORT)


class _Plain(pickle.Unpickler):
    """Tables, arrays and errors alone; nothing else is made of what a reader says."""

    def find_class(self, module: str, name: str, /) -> Any:
        own = module.startswith(f"{__package__}.")
        found = super().find_class(module, name) if own or (module, name) in _PLAIN else None
        if found is None or (own and not is_dataclass(found)):
            raise pickle.UnpicklingError(f"{module}.{name}")
        return found


def main(kind: str, path: str, seconds: str, most: str) -> int:
    """Read one file within a CPU time, s, and a memory, bytes; the status is that of this process."""
    with suppress(ImportError):  # where the system can limit the memory and the CPU time of this process
        import resource

        _, hard = resource.getrlimit(resource.RLIMIT_AS)
        memory = int(most) if hard < 0 else min(int(most), hard)
        resource.setrlimit(resource.RLIMIT_AS, (memory, hard))
        resource.setrlimit(resource.RLIMIT_CPU, (int(seconds), int(seconds) + 2))
        resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
    told = os.fdopen(os.dup(sys.stdout.fileno()), "wb")
    os.dup2(sys.stderr.fileno(), sys.stdout.fileno())  # whatever a library prints
    try:
        found = answer(kind, sys.stdin.buffer.read(), Path(path))
    except MemoryError:
        return OUT_OF_MEMORY
    with told:
        pickle.dump(found, told)
    return 0


def answer(kind: str, data: bytes, path: Path) -> list[RawTable] | BadInput:
    """The tables of a file, or why it cannot be read."""
    try:
        return READERS[kind](data, path)
    except BadInput as error:
        return error
    except MemoryError:
        raise
    except Exception as error:  # whatever a library raises on damaged files
        said = f"not {kind} that can be read ({type(error).__name__})"
        return BadInput(said, file=path, hint=SAVE_AGAIN.get(kind, f"is it whole? {EXPORT}"))


if __name__ == "__main__":
    sys.exit(main(*sys.argv[1:]))
