"""Job arrays by submitit: a suite's runs are dealt out to the jobs of an array.

Every job stores its runs in a folder of its own in `parts`, a results store like any other; they are taken over into
the suite's store while they appear.  A folder is locked while its job runs, so that a resumed run waits for jobs that
outlived the process which submitted them; a job that begins after its folder was taken over ends at once.
"""

from __future__ import annotations

import os
import shlex
import sys
import tempfile
import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from importlib import import_module
from pathlib import Path
from typing import Any

from ..models.errors import BadInput, EnvironmentFault
from ..models.folders import make_folder, read_regular, remove_folder, without_working_folder, write_atomic
from . import runner
from .environment import code_version, cpu_count
from .execution import Limits, one_line
from .journal import RUNS, is_held, new_runs
from .kinds.base import Spec
from .pool import processes
from .store import Store

PARTS, LOGS, REASON = "parts", "logs", "reason.txt"
MOST_JOBS = 100
"""Jobs of a Slurm array where no number is given."""
POLLED_EVERY_S = 0.5
CLUSTERS = ("slurm", "local")

Watch = Callable[[dict[str, Any]], object]


@dataclass(frozen=True)
class JobArray:
    """Where runs are submitted to.

    cluster : 'slurm', or 'local' for processes of this machine.
    jobs : number of jobs; None: up to `MOST_JOBS`, or one a processor of this machine.
    options : submitit's parameters of its executor, such as timeout_min, cpus_per_task, slurm_partition.
    """

    cluster: str
    jobs: int | None = None
    options: Mapping[str, str | int] = field(default_factory=dict)


@dataclass(frozen=True)
class JobShare:
    """The runs of one job, and the folder that it stores them in.

    workers : worker processes of the job; None: one a processor that it may use.
    """

    folder: Path
    specs: Sequence[Spec]
    limits: Limits
    version: str
    workers: int | None = None


def run_array(specs: Sequence[Spec], store: Store, array: JobArray, watch: Watch, limits: Limits) -> None:
    """Execute what `store` does not hold yet in jobs, take over each run as it ends, then write the tables.

    Raises
    ------
    BadInput : submitit is not installed, the cluster cannot be reached or does not know an option.
    EnvironmentFault : a job ended before its runs were finished; what is finished is kept.
    """
    folder = store.directory / PARTS
    make_folder(folder, within=store.directory)
    _adopt(folder, store, watch)
    todo = [spec for spec in specs if spec.key not in store.finished]
    if todo:
        # a folder of this user's own for submitit, which runs what lies in it: nobody else can have put anything there
        executor = _executor(array, Path(tempfile.mkdtemp(prefix=LOGS, dir=folder)))
        shares = _shares(todo, folder, store, array, limits)
        jobs = _submitted(executor, shares)
        try:
            _follow(jobs, shares, store, watch)
        except BaseException:
            for job in jobs:
                job.cancel()
            raise
    store.write_tables()
    remove_folder(folder)


def work(share: JobShare) -> None:
    """What a job does: the runs of its share, those that are stored already left out."""
    reason = share.folder / REASON
    try:
        if code_version() != share.version:
            told = f"a job has other code ({code_version()}, here {share.version})"
            raise EnvironmentFault(told, hint="install the same helmbench on every machine")
        with Store.resume(share.folder) as part, processes(share.workers) as pool:
            runner.run(share.specs, part, pool, limits=share.limits)
    except (BadInput, EnvironmentFault) as error:
        if share.folder.is_dir():
            write_atomic(reason, one_line(error).encode())
        raise


def _executor(array: JobArray, logs: Path) -> Any:
    try:
        submitit = import_module("submitit")
    except ImportError:
        hint = "install it with: pip install 'helmbench[slurm]'"
        raise BadInput("--array needs submitit", hint=hint) from None
    try:
        python = {f"{array.cluster}_python": f"{shlex.quote(sys.executable)} -P"}  # a cluster may drop the environment
        executor = submitit.AutoExecutor(folder=logs, cluster=array.cluster, **python)
        executor.update_parameters(**{"timeout_min": 24 * 60, **array.options})
    except Exception as error:  # submitit raises what it likes for an unknown option or a missing sbatch
        raise BadInput(f"--array {array.cluster}: {one_line(error)}") from None
    return executor


def _shares(specs: Sequence[Spec], folder: Path, store: Store, array: JobArray, limits: Limits) -> list[JobShare]:
    """The runs dealt out in turn, so that no share has all the long ones; a new folder for each.

    Jobs of this machine share its processors.
    """
    jobs = array.jobs or (MOST_JOBS if array.cluster == "slurm" else cpu_count())
    number, token = min(jobs, len(specs)), f"{os.getpid()}-{time.time_ns()}"
    workers = max(1, cpu_count() // number) if array.cluster == "local" else None
    shares = []
    for i in range(number):
        own = folder / f"{token}-{i}"
        Store.create(own, store.manifest).close()
        shares.append(JobShare(own.resolve(), list(specs[i::number]), limits, code_version(), workers))
    return shares


def _submitted(executor: Any, shares: Sequence[JobShare]) -> list[Any]:
    try:
        with without_working_folder():
            return executor.map_array(work, shares)
    except Exception as error:
        raise BadInput(f"the jobs cannot be submitted ({one_line(error)})") from None


def _follow(jobs: Sequence[Any], shares: Sequence[JobShare], store: Store, watch: Watch) -> None:
    """Take over the runs of jobs as they appear, until all have ended."""
    parts = [_JobResults(share.folder) for share in shares]
    waiting = dict(zip(parts, jobs, strict=True))
    while waiting:
        ended = [part for part, job in waiting.items() if job.done()]
        for part in waiting:
            part.take_over(store, watch)
        for part in ended:
            del waiting[part]
        if waiting:
            time.sleep(POLLED_EVERY_S)
    lost = [share for share in shares if any(spec.key not in store.finished for spec in share.specs)]
    reasons = [one_line(read_regular(share.folder / REASON).decode(errors="replace")) for share in lost]
    for share in shares:
        remove_folder(share.folder)
    if lost:
        told = f"{len(lost)} of {len(shares)} jobs ended before their runs were finished"
        reason = next(filter(None, reasons), "")
        why = f" ({reason})" if reason else f"; their logs are in {store.directory / PARTS}"
        raise EnvironmentFault(told + why, hint="what is finished is kept: continue with --resume")


def _adopt(folder: Path, store: Store, watch: Watch) -> None:
    """Take over what jobs of an earlier process stored; jobs that still run are waited for."""
    own = [path for path in sorted(folder.glob("*")) if path.is_dir() and not path.name.startswith(LOGS)]
    for part in [_JobResults(make_folder(path, within=folder)) for path in own]:
        while is_held(part.folder / RUNS):
            part.take_over(store, watch)
            time.sleep(POLLED_EVERY_S)
        part.take_over(store, watch)
        remove_folder(part.folder)


class _JobResults:
    """The results of one job, read on from where they were read before."""

    def __init__(self, folder: Path) -> None:
        self.folder, self._read = folder, 0

    def take_over(self, store: Store, watch: Watch) -> None:
        """Append the runs that are new here and that the store lacks."""
        runs, self._read = new_runs(self.folder / RUNS, self._read, store.kind.tables)
        for run in runs:
            if run["key"] not in store.finished:
                store.append(run)
                watch(run)
