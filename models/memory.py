"""What a computation needs of memory, compared with what the machine has, before it starts."""

from __future__ import annotations

from collections.abc import Generator
from contextlib import contextmanager
from pathlib import Path

from .errors import BadInput

SIMULATED_SAMPLE = 1_000
"""Bytes that a simulated sample takes: states, inputs, weather and channels, with the copies of sensors."""
GROUP = Path("/sys/fs/cgroup")


def require_memory(needed: float, what: str) -> None:
    """Refuse a computation that takes more bytes than the machine has free; BadInput says how much and what to do."""
    free = available_bytes()
    if needed > free:
        message = f"{what}: about {_gib(needed)} of memory are needed, {_gib(free)} are free"
        raise BadInput(message, hint="take fewer samples (a longer step, shorter or fewer records)")


@contextmanager
def bounded_memory(most: int) -> Generator[None]:
    """Let allocations that need more than `most` bytes beyond what this process has fail as a `MemoryError`; Linux."""
    try:
        import resource
    except ImportError:
        yield
        return
    import psutil

    used = getattr(psutil.Process().memory_info(), "data", None)
    before, hard = resource.getrlimit(resource.RLIMIT_DATA)
    if used is None or 0 <= before <= used + most:
        yield
        return
    resource.setrlimit(resource.RLIMIT_DATA, (used + most if hard < 0 else min(used + most, hard), hard))
    try:
        yield
    finally:
        resource.setrlimit(resource.RLIMIT_DATA, (before, hard))


def available_bytes() -> float:
    """Bytes that this process may still take: free on the machine, in its control group and under its own limit."""
    import psutil

    free = float(psutil.virtual_memory().available)
    most, used = _number(GROUP / "memory.max"), _number(GROUP / "memory.current")
    if most is not None and used is not None:
        free = min(free, most - used)
    return min(free, _under_limit())


def _under_limit() -> float:
    """Bytes left of the limit of this process's address space."""
    try:
        import resource
    except ImportError:
        return float("inf")
    import psutil

    most, _ = resource.getrlimit(resource.RLIMIT_AS)
    return float("inf") if most == resource.RLIM_INFINITY else most - psutil.Process().memory_info().vms


def _number(path: Path) -> float | None:
    try:
        return float(path.read_text())
    except (OSError, ValueError):  # another system, or "max"
        return None


def _gib(size: float) -> str:
    return f"{max(size, 0.0) / 2**30:.3g} GiB"
