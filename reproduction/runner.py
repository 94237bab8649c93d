"""Studies as runs of the bench, one a study and index: it executes them, and keeps each in its store when it ends."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from ..bench import runner
from ..bench.environment import code_version, environment
from ..bench.execution import guarded, measured_cost
from ..bench.journal import read_runs
from ..bench.kinds.base import TIMES, RunKind, Tables
from ..bench.pool import Pool
from ..bench.store import MANIFEST, RUNS, Store, read_manifest
from ..datasets.measured import data_dir, dataset
from ..models.errors import BadInput
from ..models.folders import check_regular
from ..models.plain import plain
from .claims.claim import Paper
from .papers.study import StudyResult, stream, studies_of

STORED = Path(__file__).parent / "stored" / RUNS
"""Stored runs of studies on measured sets, used where the data are missing."""
KEYS = {"paper": "string", "study": "string", "index": "int"}
Run = dict[str, Any]
"""A finished run: key, row (with status and error), parameters (name and value of every number), series."""


@dataclass(frozen=True)
class StudyJob:
    """One run: a paper's study with one index; another seed draws other random numbers."""

    paper: str
    study: str
    index: int
    seed: int = 0

    @property
    def key(self) -> str:
        """The same for every seed: a directory holds the runs of one."""
        return f"{self.paper}/{self.study}/{self.index:04d}"

    def row_key(self) -> dict[str, Any]:
        """The key columns of the store."""
        return {"paper": self.paper, "study": self.study, "index": self.index}


def execute(job: StudyJob) -> Run:
    """One run; an exception in it becomes its error."""
    study = studies_of(job.paper)[job.study]
    if study.measured and not is_available(study.measured) and (stored := runs_of([job], read_runs(STORED))):
        return stored[0]
    series: dict[str, Any] = {}

    def work(row: dict[str, Any]) -> list[dict[str, Any]]:
        with measured_cost(row):
            result = study.function(stream(job.paper, job.study, job.index, job.seed), index=job.index)
        series.update(result.series if job.index < study.drawn else {})
        return [{"name": name, "value": float(value)} for name, value in result.values.items()]

    return plain(guarded(job, work) | {"series": series})


TABLES = Tables(
    keys=tuple(KEYS),
    wide_file="studies.parquet",
    wide=KEYS | {"status": "string", "error": "string"} | TIMES,
    long_file="values.parquet",
    long=KEYS | {"name": "string", "value": "float"},
    long_keys=("name",),
)
KIND = RunKind(name="reproduction", stored=lambda: TABLES, execute=execute)
"""Runs of studies: a number a row of the long table, arrays for figures beside it."""


class StudyStore(Store):
    """The directory of a reproduction; runs that failed are made again."""

    @property
    def finished(self) -> frozenset[str]:
        return frozenset(run["key"] for run in self.runs if not run["row"]["error"])


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


def open_store(directory: Path, resume: bool, planned: int, seed: int = 0) -> Store:
    """The store of a directory, which is made, or was started by this version with this seed, for this process alone.

    Raises `BadInput` where it is not vacant, not to be resumed, or held by another process.
    """
    expected = {"version": code_version(), "seed": seed}
    if not (resume and check_regular(directory / MANIFEST)):
        manifest = {"kind": KIND.name, "suite": KIND.name, "planned": planned, **expected, **environment()}
        return StudyStore.create(directory, manifest, KIND)
    runner.refuse_other(directory, read_manifest(directory, KIND.name), expected)
    return StudyStore.resume(directory, KIND)


def compute(jobs: Sequence[StudyJob], store: Store, pool: Pool, watch: Callable[[Run | None], object]) -> list[Run]:
    """Execute the runs that the store lacks, and the stored runs of all jobs in their order.

    `watch` is called with every run, with None for one that was stored before.
    """
    for _ in store.finished.intersection(job.key for job in jobs):
        watch(None)
    runner.run(jobs, store, pool, watch)
    return runs_of(jobs, store.runs)


def runs_of(jobs: Iterable[StudyJob], stored: Iterable[Run]) -> list[Run]:
    """The stored ones of the runs, in order."""
    by_key = {run["key"]: run for run in stored}
    return [by_key[job.key] for job in jobs if job.key in by_key]


def is_available(measured: str) -> bool:
    """Whether the folder of a measured set exists."""
    return (data_dir() / dataset(measured).folder).is_dir()


def is_of(run: Run, paper: str, study: str) -> bool:
    """Whether it is a run of a paper's study."""
    return (run["row"]["paper"], run["row"]["study"]) == (paper, study)


def result_of(run: Run) -> StudyResult:
    """A stored run as its study returned it; null is nan."""
    values = {one["name"]: np.nan if one["value"] is None else one["value"] for one in run["parameters"]}
    return StudyResult(values, {name: np.array(array, float) for name, array in run["series"].items()})
