"""Running one spec: its failure becomes a row, its cost is measured, its time and memory are limited."""

from __future__ import annotations

import re
import signal
import sys
import threading
import time
import warnings
from collections.abc import Callable, Generator
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Any

from ..models.cache import BUILDING
from ..models.errors import BadInput, CannotFit, EnvironmentFault, FitFailed
from .kinds.base import Spec

STATUS, RESET = Path("/proc/self/status"), Path("/proc/self/clear_refs")
"""Where Linux says what memory this process takes, and where its peak is reset."""
OUT_OF_MEMORY = "out of memory"
"""How the error of a run begins that needed more memory than there is."""


def guarded(spec: Spec, work: Callable[[dict[str, Any]], list[dict[str, Any]]]) -> dict[str, Any]:
    """The finished run of a spec whose `work` fills in its row and returns its further rows.

    Raises `EnvironmentFault` where the machine is at fault: that is no result of a method.
    """
    row: dict[str, Any] = spec.row_key() | {"status": "failed", "error": None}
    parameters: list[dict[str, Any]] = []
    with quiet():
        try:
            parameters = work(row)
            row["status"] = "ok"
        except CannotFit as reason:
            row |= {"status": "not_applicable", "error": one_line(reason)}
        except EnvironmentFault:
            raise
        except (FitFailed, BadInput) as reason:
            row["error"] = one_line(reason)
        except MemoryError as error:
            row["error"] = one_line(f"{OUT_OF_MEMORY}: {error}")
        except Exception as error:  # an error inside a method is a row, too
            row["error"] = one_line(f"{type(error).__name__}: {error}")
    return {"key": spec.key, "row": row, "parameters": parameters}


def one_line(message: object, most: int = 400) -> str:
    """A message without line breaks and control characters, cut to a sensible length."""
    text = "".join(letter if letter.isprintable() else "?" for letter in " ".join(str(message).split()))
    return text if len(text) <= most else text[: most - 3] + "..."


@contextmanager
def measured_cost(row: dict[str, Any]) -> Generator[None]:
    """Wall time, CPU time and peak memory of the enclosed code, entered in the row also where it raises an error."""
    peak = reset_peak_memory()
    wall, cpu = time.perf_counter(), time.process_time()
    try:
        yield
    finally:
        row |= {"wall_s": time.perf_counter() - wall, "cpu_s": time.process_time() - cpu}
        row["peak_memory_mib"] = peak()


def reset_peak_memory() -> Callable[[], float | None]:
    """Start a measurement of this process's peak resident memory; the result gives it in MiB.

    On Linux the peak is reset first, so that it is the peak since this call (with interpreter and libraries);
    elsewhere it is the peak since the process started, and None where the system does not give it.
    """
    try:
        with RESET.open("wb", buffering=0) as file:
            file.write(b"5")
        return _peak_since_reset if _peak_is_told() else _peak_since_start
    except OSError:
        return _peak_since_start


@cache
def _peak_is_told() -> bool:
    """Whether the system says what the peak since a reset is."""
    try:
        return _peak_since_reset() > 0.0
    except (OSError, IndexError):
        return False


def _peak_since_reset() -> float:
    with STATUS.open("rb", buffering=0) as file:
        return int(file.read().split(b"VmHWM:", 1)[1].split(maxsplit=1)[0]) / 1024.0


def _peak_since_start() -> float | None:
    try:
        import resource
    except ImportError:
        return None
    peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    return peak / (1024.0**2 if sys.platform == "darwin" else 1024.0)


def attempt(action: Callable[[], object]) -> None:
    """Do something in advance: its failure is only a warning, since the run itself will fail with the same reason."""
    try:
        action()
    except EnvironmentFault:
        raise
    except Exception as error:
        warnings.warn(one_line(error), RuntimeWarning, stacklevel=2)


@contextmanager
def quiet() -> Generator[None]:
    """One BLAS thread, and no numerical warnings: the scores show bad numbers."""
    import numpy as np

    from ..estimation.results.fit import blas_limited

    with blas_limited(), np.errstate(all="ignore"), warnings.catch_warnings():
        warnings.simplefilter("ignore")
        yield


GIB = 2**30
LONGEST_S = 1e8
LATE, DIED = "out of time", "worker process died"
ENDED = (LATE, DIED, OUT_OF_MEMORY)
"""How the error of a run begins that a limit of the machine ended, not its method."""


class OutOfTime(BaseException):
    """Raised in a run that takes too long; no `Exception`, so that a method does not take it for one of its own."""


@dataclass(frozen=True)
class Limits:
    """What one run may take: `seconds` of wall time, in which the compilation of kernels does not count, and `gib` of
    memory that its process allocates.  None: no limit.

    A run out of time is interrupted; one that does not react within `grace_s` is ended together with its process.
    """

    seconds: float | None = None
    gib: float | None = None
    grace_s: float = 20.0

    def check(self) -> None:
        """Raise `BadInput` for a limit that cannot be used, or not on this system."""
        if self.seconds is not None and not 0.0 < self.seconds <= LONGEST_S:
            raise BadInput(
                f"--timeout is {self.seconds:g} s", hint=f"a number above 0, at most {LONGEST_S:g}, is needed"
            )
        if self.seconds is not None and not hasattr(signal, "setitimer"):
            raise BadInput("--timeout needs the timers of Linux or macOS")
        if self.gib is not None and not 0.0 < self.gib < 2**20:
            raise BadInput(f"--memory is {self.gib:g} GiB", hint="a number above 0 is needed")
        if self.gib is not None and not _limits_memory():
            raise BadInput("--memory needs Linux")

    def run(self, execute: Callable[[Spec], dict[str, Any]], spec: Spec) -> dict[str, Any]:
        """`execute(spec)` within the limits; one that is out of time becomes a failed run that says so."""
        try:
            with ExitStack() as stack:
                if self.gib is not None:
                    stack.enter_context(_memory(self.gib))
                if self.seconds is not None:
                    stack.enter_context(_time(self.seconds, self.grace_s))
                return execute(spec)
        except OutOfTime:
            return self.failed(spec, "")

    def failed(self, spec: Spec, reason: str) -> dict[str, Any]:
        """The finished run of a spec that was ended; `reason`: what the pool says of the worker, empty if it lives."""
        ended = sorted(set(re.findall(r"SIG[A-Z]+", reason)))
        told = one_line(f"{DIED} ({', '.join(ended) or reason})")
        if not reason or "SIGALRM" in ended:
            told = f"{LATE}: more than {self.seconds:g} s (--timeout)" if self.seconds else told
        elif self.gib is not None:
            told += f"; its memory was limited to {self.gib:g} GiB (--memory)"
        return {"key": spec.key, "row": spec.row_key() | {"status": "failed", "error": told}, "parameters": []}


def _limits_memory() -> bool:
    try:
        import resource
    except ImportError:
        return False
    return hasattr(resource, "RLIMIT_DATA")


@contextmanager
def _memory(gib: float) -> Generator[None]:
    """Let allocations beyond the limit fail, which is a `MemoryError` in Python and numpy."""
    import resource

    before, most = resource.getrlimit(resource.RLIMIT_DATA)
    limit = int(gib * GIB)
    resource.setrlimit(resource.RLIMIT_DATA, (limit if most < 0 else min(limit, most), most))
    try:
        yield
    finally:
        resource.setrlimit(resource.RLIMIT_DATA, (before, most))


@contextmanager
def _time(seconds: float, grace_s: float) -> Generator[None]:
    """Raise `OutOfTime` in the main thread after so many seconds, without those in which kernels are built.

    A thread watches, and a timer of the system ends the process where Python does not come to the turn any more.
    """
    done, begin, built = threading.Event(), time.monotonic(), BUILDING.seconds()

    def left() -> float:
        return seconds - (time.monotonic() - begin) + (BUILDING.seconds() - built)

    def watch() -> None:
        while not done.wait(min(max(left(), 0.01), 1.0)):
            if (rest := left()) <= 0.0:
                signal.pthread_kill(main, signal.SIGUSR1)
                return
            signal.setitimer(signal.ITIMER_REAL, rest + grace_s)

    def stop(*_: object) -> None:
        raise OutOfTime

    main = threading.main_thread().ident or 0
    former = [signal.signal(signal.SIGUSR1, stop), signal.signal(signal.SIGALRM, signal.SIG_DFL)]
    signal.setitimer(signal.ITIMER_REAL, seconds + grace_s)
    watcher = threading.Thread(target=watch, daemon=True)
    watcher.start()
    try:
        yield
    finally:
        done.set()
        watcher.join()
        signal.setitimer(signal.ITIMER_REAL, 0.0)
        signal.signal(signal.SIGUSR1, former[0])
        signal.signal(signal.SIGALRM, former[1])


UNLIMITED = Limits()
