"""What a run was made with: versions, platform, processor and threads."""

from __future__ import annotations

import hashlib
import os
import platform
import sys
from functools import lru_cache
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path
from typing import Any

PACKAGES = ("helmbench", "numpy", "scipy", "numba", "llvmlite", "sympy", "pandas", "pyarrow", "joblib")
THREAD_VARIABLES = (
    "OMP_NUM_THREADS",
    "OPENBLAS_NUM_THREADS",
    "MKL_NUM_THREADS",
    "BLIS_NUM_THREADS",
    "VECLIB_MAXIMUM_THREADS",
    "NUMBA_NUM_THREADS",
)
"""Environment variables that limit every worker to one thread."""


def environment() -> dict[str, Any]:
    """Versions, platform and processor as plain values; no host name and no paths."""
    return {
        "python": platform.python_version(),
        "implementation": sys.implementation.name,
        "platform": platform.platform(),
        "machine": platform.machine(),
        "cpu": cpu_name(),
        "cpus": cpu_count(),
        "packages": {name: _version(name) for name in PACKAGES},
    }


def cpu_count() -> int:
    """Processors that this process may use."""
    try:
        return len(os.sched_getaffinity(0))
    except AttributeError:
        return os.cpu_count() or 1


def thread_pools() -> list[tuple[str, int]]:
    """Libraries of linear algebra that are loaded, and how many threads each uses."""
    from threadpoolctl import threadpool_info

    return [(str(pool["internal_api"]), int(pool["num_threads"])) for pool in threadpool_info()]


def cpu_name() -> str:
    """The processor's model name where the system gives it."""
    try:
        lines = Path("/proc/cpuinfo").read_text(encoding="utf-8").splitlines()
    except OSError:
        return platform.processor()
    names = [line.split(":", 1)[1].strip() for line in lines if line.startswith("model name")]
    return names[0] if names else platform.processor()


def _version(name: str) -> str | None:
    try:
        return version(name)
    except PackageNotFoundError:
        return None


def code_version() -> str:
    """Version of the installed package, with a digest of its sources."""
    return f"{environment()['packages']['helmbench']}+{_source_digest()}"


@lru_cache(maxsize=1)
def _source_digest() -> str:
    rooms = Path(__file__).resolve().parents[1]
    digest = hashlib.sha256()
    for folder in ("models", "datasets", "checks", "estimation", "methods", "diagnosis", "bench"):
        for path in sorted((rooms / folder).rglob("*")):
            if path.suffix in (".py", ".yaml"):
                digest.update(path.relative_to(rooms).as_posix().encode() + b"\0" + path.read_bytes())
    return digest.hexdigest()[:12]
