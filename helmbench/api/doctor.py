"""Whether helmbench can work here: versions, compiled code, data, threads, disk and permissions."""

from __future__ import annotations

import os
import re
import shutil
import sys
import tempfile
import warnings
from collections.abc import Iterator
from dataclasses import dataclass
from html import escape
from importlib.metadata import PackageNotFoundError, requires, version
from pathlib import Path
from types import FunctionType
from typing import Any

from ..models.errors import BadInput
from ..reporting.tables import Table, console, field, html, make_table

OK, WARNING, FAULT = "ok", "warning", "fault"
LITTLE, TOO_LITTLE = 2e9, 2e8
"""Free bytes of a disk below which it is nearly full, and below which work ends."""
LARGE_MB = 2000.0
REQUIREMENT = re.compile(r"([A-Za-z0-9._-]+)\s*>=\s*([0-9.]+)$")


@dataclass(frozen=True)
class HealthFinding:
    """One thing that was looked at.  status : 'ok', 'warning' or 'fault';  todo : what to do, '' where nothing is."""

    what: str
    status: str
    told: str
    todo: str = ""


@dataclass(frozen=True, repr=False)
class Health:
    """What `doctor` found, in the order in which it looked."""

    findings: tuple[HealthFinding, ...]

    @property
    def status(self) -> str:
        """The worst status: 'ok', 'warning' or 'fault'."""
        return max((one.status for one in self.findings), key=(OK, WARNING, FAULT).index, default=OK)

    def to_json(self) -> dict[str, Any]:
        """Plain values."""
        return {"status": self.status, "findings": [vars(one) for one in self.findings]}

    def summary(self) -> str:
        """The findings as a table in plain text."""
        return console(self._table())

    def __repr__(self) -> str:
        return f"<Health: {self.status}>"

    def _repr_html_(self) -> str:
        return f"<p>{escape(self.status)}</p>{html(self._table())}"

    def _table(self) -> Table:
        columns = [field("status"), field("what"), field("told", "found"), field("todo", "to do")]
        return make_table(columns, self.findings)


def doctor() -> Health:
    """Look at everything that helmbench needs of a machine; nothing is changed but the cache of compiled code.

    Returns
    -------
    Findings with a status each: 'ok', 'warning' (it works, but not well) or 'fault' (something does not work), and
    what to do.
    """
    checks = (_python, _packages, _plugins, _compiled, _cache, _data, _threads, _disk, _permissions, _output)
    return Health(tuple(finding for check in checks for finding in _guarded(check)))


def _guarded(check: FunctionType) -> list[HealthFinding]:
    """The findings of a check; one that cannot be carried out is a fault."""
    name = check.__name__.removeprefix("_").replace("_", " ")
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            return list(check())
    except BadInput as error:
        told = f"{error.message} ({error.file})" if error.file else error.message
        return [HealthFinding(name, FAULT, told, error.hint or "")]
    except Exception as error:  # whatever a broken installation raises
        return [HealthFinding(name, FAULT, f"{type(error).__name__}: {error}", "install helmbench anew: pip install .")]


def _python() -> Iterator[HealthFinding]:
    from ..bench.environment import environment

    found = environment()
    told = f"helmbench {found['packages']['helmbench']}, Python {found['python']} ({found['platform']})"
    yield HealthFinding("python", OK, told)


def _packages() -> Iterator[HealthFinding]:
    """Every declared dependency is there, in a version that suits."""
    needed = [found.groups() for text in requires("helmbench") or () if (found := REQUIREMENT.match(text))]  # no extras
    bad = [(name, own, least) for name, least in needed if _numbers(own := _version(name)) < _numbers(least)]
    for name, own, least in bad:
        yield HealthFinding("package", FAULT, f"{name} is {own}, {least} is needed", f"pip install '{name}>={least}'")
    if not bad:
        yield HealthFinding("packages", OK, f"{len(needed)} packages in suitable versions")


def _version(name: str) -> str:
    try:
        return version(name)
    except PackageNotFoundError:
        return "missing"


def _numbers(text: str) -> tuple[int, ...]:
    return tuple(int(part) for part in re.findall(r"\d+", text.split("+")[0])[:3])


def _plugins() -> Iterator[HealthFinding]:
    from ..diagnosis.causes.registry import all_causes
    from ..methods.registry import methods

    yield HealthFinding("registry", OK, f"{len(methods())} methods and {len(all_causes())} causes can be loaded")


def _compiled() -> Iterator[HealthFinding]:
    """A small simulation with compiled code gives what the equation says."""
    import math
    import time

    from ..models.model import resolve
    from .simulation import simulate

    started = time.perf_counter()
    model = resolve("nomoto-1").with_coefficients([-0.1, 0.01])
    record = simulate(model, "turn:10", duration_s=200.0, dt_s=0.5)
    error = abs(record.column("yaw_rate_rad_s")[-1] - 0.1 * math.radians(10.0))
    seconds = time.perf_counter() - started
    if error < 1e-6:
        yield HealthFinding("compiled code", OK, f"a simulation ran in {seconds:.2g} s")
    else:
        told = f"a simulation is off by {error:.2g} rad/s"
        yield HealthFinding("compiled code", FAULT, told, "delete the folder of the cache")


def _cache() -> Iterator[HealthFinding]:
    from ..models.cache import VARIABLE, cache_folder, stored

    folder = cache_folder()
    files = [path for path in folder.rglob("*") if path.is_file()]
    size = sum(path.stat().st_size for path in files) / 1e6
    damaged = [path for path in files if path.suffix == ".kernel" and stored(path) is None]
    told, todo = f"{folder}: {len(files)} files, {size:.0f} MB", ""
    if damaged:
        told += f"; {len(damaged)} damaged"
        todo = "nothing: they are built anew when needed; if they come again, check the disk"
    elif size > LARGE_MB:
        todo = "delete the folder: old versions are in it, and it is built anew"
    elif Path(tempfile.gettempdir()) in folder.parents and VARIABLE not in os.environ:
        told, todo = f"{told}; it is lost at the end", f"set {VARIABLE} to a folder that can be written"
    yield HealthFinding("cache", WARNING if todo else OK, told, todo)


def _data() -> Iterator[HealthFinding]:
    from ..datasets.measured import ENVIRONMENT, data_dir, missing_files
    from ..datasets.measured_sets import DATASETS

    folder = data_dir()
    if os.environ.get(ENVIRONMENT) and not folder.is_dir():
        told = f"{ENVIRONMENT} names {folder}, which is no folder"
        yield HealthFinding("data", FAULT, told, f"make it, or unset {ENVIRONMENT}")
        return
    for name, source in DATASETS.items():
        lost = missing_files(name)
        if not lost:
            yield HealthFinding(f"data {name}", OK, f"{len(source.runs)} files, as published")
        elif len(lost) == len(source.runs):
            yield HealthFinding(f"data {name}", OK, f"not fetched (optional: helmbench fetch {name})")
        else:
            told = f"{len(lost)} of {len(source.runs)} files are missing or not as published"
            yield HealthFinding(f"data {name}", WARNING, told, f"helmbench fetch {name}")


def _threads() -> Iterator[HealthFinding]:
    from ..bench.environment import THREAD_VARIABLES, cpu_count, thread_pools

    cpus = cpu_count()
    pools = thread_pools()
    told = ", ".join(f"{library} {threads}" for library, threads in pools) or "none"
    most = max((threads for _, threads in pools), default=1)
    given = {name: value for name in THREAD_VARIABLES if (value := os.environ.get(name))}
    wrong = [name for name, value in given.items() if not (value.isascii() and value.isdigit() and int(value) > 0)]
    if wrong:
        todo = f"set {wrong[0]} to a whole number, at least 1"
        yield HealthFinding("threads", FAULT, f"{wrong[0]} is {given[wrong[0]]!r}", todo)
    elif most > cpus:
        todo = "set OMP_NUM_THREADS=1: more threads wait for each other"
        yield HealthFinding("threads", WARNING, f"{told} on {cpus} processors", todo)
    else:
        yield HealthFinding("threads", OK, f"{cpus} processors; linear algebra: {told}")


def _disk() -> Iterator[HealthFinding]:
    from ..datasets.measured import data_dir
    from ..models.cache import cache_folder

    places = {
        "cache": cache_folder(),
        "data": data_dir(),
        "working folder": Path.cwd(),
        "temporary files": Path(tempfile.gettempdir()),
    }
    for name, place in places.items():
        folder = next(one for one in (place, *place.parents) if one.exists())
        free = shutil.disk_usage(folder).free
        status = FAULT if free < TOO_LITTLE else WARNING if free < LITTLE else OK
        todo = "free some space" if status != OK else ""
        yield HealthFinding(f"disk of {name}", status, f"{free / 1e9:.1f} GB free at {folder}", todo)


def _permissions() -> Iterator[HealthFinding]:
    places = (
        ("temporary files", Path(tempfile.gettempdir()), FAULT, "set TMPDIR to a folder that can be written"),
        ("working folder", Path.cwd(), WARNING, "write results elsewhere with -o"),
    )
    for name, place, status, todo in places:
        try:
            tempfile.TemporaryFile(dir=place).close()
        except OSError as error:
            yield HealthFinding(f"writing, {name}", status, f"{place}: {error.strerror or error}", todo)
        else:
            yield HealthFinding(f"writing, {name}", OK, f"{place} can be written")


def _output() -> Iterator[HealthFinding]:
    """Tables hold ² and ±: the terminal must be able to show them."""
    encoding = sys.stdout.encoding or "ascii"
    try:
        "R² ± – −".encode(encoding)
    except UnicodeEncodeError:
        yield HealthFinding("terminal", WARNING, f"{encoding} lacks characters of the tables", "set PYTHONUTF8=1")
    else:
        yield HealthFinding("terminal", OK, f"shows {encoding}")
