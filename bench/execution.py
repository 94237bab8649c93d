"""Running one spec: its failure becomes a row, its cost is measured."""

from __future__ import annotations

import sys
import time
import warnings
from collections.abc import Callable, Generator
from contextlib import contextmanager
from functools import cache
from pathlib import Path
from typing import TYPE_CHECKING, Any

from ..models.errors import BadInput, CannotFit, EnvironmentFault, FitFailed

if TYPE_CHECKING:
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
