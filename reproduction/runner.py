"""Executes studies over their seeds and stores every finished run in a file, so that a stopped computation resumes."""

from __future__ import annotations

import io
import json
import time
import zlib
from collections.abc import Callable, Generator, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any
from zipfile import BadZipFile

import numpy as np

from ..bench.environment import code_version, environment
from ..bench.execution import one_line, quiet
from ..bench.store import check_vacant, locked
from ..models.data_file import load
from ..models.errors import BadInput, EnvironmentFault
from ..models.folders import check_regular, make_folder, write_atomic
from ..models.plain import plain
from .claims.claim import Paper
from .papers.study import StudyResult, stream, studies_of

if TYPE_CHECKING:
    from ..bench.pool import Pool

MANIFEST, RUNS = "reproduction.json", "runs"
STORED = Path(__file__).parent / "stored"
"""Stored runs of studies on measured sets, used where the data are missing."""


@dataclass(frozen=True)
class StudyJob:
    """One run: a paper's study with one index; another seed draws other random numbers."""

    paper: str
    study: str
    index: int
    seed: int = 0

    def path(self, directory: Path) -> Path:
        """The file of the stored run."""
        return directory / RUNS / self.paper / self.study / f"{self.index:04d}.json"


@dataclass(frozen=True)
class StudyRun:
    """A finished run; `error` says why it has no values."""

    job: StudyJob
    values: dict[str, Any]
    series: dict[str, np.ndarray]
    error: str | None
    cpu_s: float


def plan(papers: Sequence[Paper], seed: int = 0) -> list[StudyJob]:
    """Every run that the papers' claims and figures need, in order of index, so that each kernel is compiled once."""
    found = []
    for paper in papers:
        known = studies_of(paper.paper)
        for name in paper.studies:
            if name not in known:
                raise BadInput(f"has no study {name!r}", file=f"paper {paper.paper}")
            found += [StudyJob(paper.paper, name, index, seed) for index in range(known[name].seeds)]
    return sorted(found, key=lambda job: job.index)


@contextmanager
def open_directory(directory: Path, resume: bool, seed: int = 0) -> Generator[None]:
    """Make a directory of runs, or check that a started one was made by this version, and hold it for this process.

    Raises `BadInput` where it is not vacant, not to be resumed, or held by another process.
    """
    path = directory / MANIFEST
    resume = resume and check_regular(path)
    if not resume:
        check_vacant(directory, MANIFEST)
    make_folder(directory)
    with locked(directory):
        if not resume:
            check_vacant(directory, MANIFEST)
            text = json.dumps({"version": code_version(), "seed": seed, **environment()}, indent=1)
            write_atomic(path, text.encode() + b"\n")
        elif _manifest(path).get("version") != code_version():
            hint = "start again in a new directory"
            raise BadInput("cannot be resumed: version differs from the one it was started with", file=path, hint=hint)
        elif _manifest(path).get("seed") != seed:
            raise BadInput(f"cannot be resumed with seed {seed}: it was started with another one", file=path)
        yield


def compute(
    jobs: Sequence[StudyJob], directory: Path, pool: Pool, watch: Callable[[StudyRun | None], object] = lambda run: None
) -> None:
    """Execute the runs that the directory lacks and store each when it ends.

    `watch` is called with every run, with None for one that was stored before.  Failed and damaged runs are repeated.
    """
    todo = []
    for job in jobs:
        stored = _undamaged(job, directory)
        if stored is None or stored.error:
            todo.append(job)
        else:
            watch(None)
    for job, result, error in pool.outcomes(execute, todo):
        run = result if error is None else _lost(job, error)
        write_run(run, directory)
        watch(run)


def execute(job: StudyJob) -> StudyRun:
    """One run; an exception in it becomes its error."""
    study = studies_of(job.paper)[job.study]
    if study.measured and not is_available(study.measured) and (stored := read_run(job, STORED)) is not None:
        return stored
    begin = time.process_time()
    values, series, error = {}, {}, None
    with quiet():
        try:
            result = study.function(stream(job.paper, job.study, job.index, job.seed), index=job.index)
            values = {key: plain(value) for key, value in result.values.items()}
            series = {name: np.asarray(array) for name, array in result.series.items()}
        except EnvironmentFault:
            raise
        except Exception as reason:
            error = one_line(f"{type(reason).__name__}: {reason}")
    kept = series if job.index < study.drawn else {}
    return StudyRun(job, values, kept, error, time.process_time() - begin)


def is_available(measured: str) -> bool:
    """Whether the folder of a measured set exists."""
    from ..datasets.measured import data_dir, dataset

    return (data_dir() / dataset(measured).folder).is_dir()


def write_run(run: StudyRun, directory: Path) -> None:
    """Store a run: first its series, then, atomically, the file that marks it as finished."""
    path = run.job.path(directory)
    make_folder(path.parent, within=directory)
    if run.series:
        buffer = io.BytesIO()
        np.savez_compressed(buffer, allow_pickle=False, **run.series)
        write_atomic(path.with_suffix(".npz"), buffer.getvalue())
    stored = {"values": run.values, "error": run.error, "cpu_s": round(run.cpu_s, 3)}
    write_atomic(path, json.dumps(plain(stored), allow_nan=False).encode() + b"\n")


def read_run(job: StudyJob, directory: Path) -> StudyRun | None:
    """A stored run; None where there is none."""
    path = job.path(directory)
    if not check_regular(path):
        return None
    try:
        data = load(path)
        values, error = dict(data["values"]), data["error"]
        series = path.with_suffix(".npz")
        arrays = dict(np.load(series)) if check_regular(series) else {}
        return StudyRun(job, values, arrays, None if error is None else str(error), float(data["cpu_s"]))
    except (ValueError, KeyError, TypeError, OSError, EOFError, BadZipFile, zlib.error) as error:
        raise BadInput(f"cannot be read ({one_line(error)})", file=path) from None


def _undamaged(job: StudyJob, directory: Path) -> StudyRun | None:
    try:
        return read_run(job, directory)
    except BadInput:
        return None


def stored_runs(jobs: Sequence[StudyJob], directory: Path) -> Iterator[StudyRun]:
    """The stored ones of the runs."""
    for job in jobs:
        run = read_run(job, directory)
        if run is not None:
            yield run


def result_of(run: StudyRun) -> StudyResult:
    """A stored run as its study returned it."""
    values = {key: float("nan") if value is None else value for key, value in run.values.items()}
    return StudyResult(values, run.series)


def _lost(job: StudyJob, error: BaseException) -> StudyRun:
    return StudyRun(job, {}, {}, one_line(f"worker process died ({type(error).__name__}: {error})"), 0.0)


def _manifest(path: Path) -> dict[str, Any]:
    data = load(path)
    return data if isinstance(data, dict) else {}
