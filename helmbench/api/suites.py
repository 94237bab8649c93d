"""Suites: running them, reading what is stored, and the leaderboard."""

from __future__ import annotations

import sys
from collections import Counter
from collections.abc import Callable, Mapping, Sequence
from contextlib import AbstractContextManager
from dataclasses import dataclass, replace
from html import escape
from pathlib import Path
from typing import TYPE_CHECKING, Any

from ..models.argument_types import typed
from ..models.errors import BadInput, visible
from ..models.extras import extras_told

if TYPE_CHECKING:
    from os import PathLike

    import pandas as pd

    from ..bench.execution import Limits
    from ..bench.kinds.base import Kind, RunSelection
    from ..bench.merging import MergeCounts
    from ..bench.pool import Pool
    from ..bench.store import Store
    from ..bench.suites import Trust
    from ..reporting.leaderboard.board import Leaderboard
    from ..reporting.leaderboard.comparing import Changes

QUICK = "quick"
"""The suite that is run where none is named."""
STATUSES = ("ok", "failed", "not_applicable")


@dataclass(frozen=True, repr=False)
class SuiteResults:
    """What a suite's directory holds: its manifest and the rows of the runs that are finished, sorted by their keys."""

    directory: Path
    manifest: Mapping[str, Any]
    rows: tuple[Mapping[str, Any], ...]

    @property
    def suite(self) -> str:
        """Name of the suite."""
        return str(self.manifest["suite"])

    @property
    def complete(self) -> bool:
        """Whether every planned run is finished."""
        return len(self.rows) >= int(self.manifest["planned"])

    @property
    def counts(self) -> dict[str, int]:
        """Number of runs by status: ok, failed, not_applicable."""
        return {status: sum(row["status"] == status for row in self.rows) for status in STATUSES}

    @property
    def failures(self) -> list[dict[str, Any]]:
        """The failed runs: the columns that tell them apart, and the error."""
        return [{key: row[key] for key in (*self._kind().failure_columns, "error")} for row in self._failed()]

    @property
    def failure_texts(self) -> dict[str, int]:
        """The failed runs in words -> how many failed so."""
        return dict(Counter(map(self._kind().describe, self._failed())))

    @extras_told()
    def runs(self) -> pd.DataFrame:
        """A row a run, as in results.parquet (suites of kind diagnosis: diagnosis.parquet)."""
        from ..bench.store import read_tables

        return read_tables(self.directory)[0]

    @extras_told()
    def parameters(self) -> pd.DataFrame:
        """A row a run and parameter, as in parameters.parquet (suites of kind diagnosis: diagnosis_sizes.parquet)."""
        from ..bench.store import read_tables

        return read_tables(self.directory)[1]

    def _failed(self) -> list[Mapping[str, Any]]:
        return [row for row in self.rows if row["status"] == "failed"]

    def _kind(self) -> Kind:
        from ..bench.store import stored_kind

        return stored_kind(self.manifest)

    def __repr__(self) -> str:
        counts = ", ".join(f"{number} {status.replace('_', ' ')}" for status, number in self.counts.items())
        state = "" if self.complete else f" of {self.manifest['planned']}"
        return f"<SuiteResults {self.suite!r}: {len(self.rows)}{state} runs, {counts}; {self.directory}>"

    def _repr_html_(self) -> str:
        told = "".join(f"<li>{escape(text)} ({number})</li>" for text, number in self.failure_texts.items())
        return f"<p>{escape(repr(self)[1:-1])}</p>{f'<ul>{told}</ul>' if told else ''}"


@typed
def run_suite(
    suite: str | None = None,
    *,
    directory: str | PathLike[str],
    methods: Sequence[str] = (),
    vessels: Sequence[str] = (),
    seeds: int | None = None,
    seed: int | None = None,
    jobs: int | None = None,
    scheduler: str | None = None,
    reuse: Sequence[str | PathLike[str]] = (),
    timeout_s: float | None = None,
    memory_gib: float | None = None,
    resume: bool = False,
    trust: Trust = False,
    progress: bool = False,
    message: Callable[[str], object] | None = None,
) -> SuiteResults:
    """Run a suite; every finished run is stored at once.

    Parameters
    ----------
    suite : a name of `list_suites` or the path of a suite file; None: 'quick', or with `resume` what was started.
    directory : of the results; new or empty unless the run is resumed.
    methods : only these methods; also 'path.py:Class', 'tuned:ridge' and the like.
    vessels : only these vessels or measured sets.
    seeds : number of seeds, or of rounds of a diagnosis suite; None: the suite's.
    seed : seed from which a diagnosis suite draws its cases; None: a new one.
    jobs : worker processes, at most one for each processor; None: one for each processor.
    scheduler : 'tcp://host:port' of a dask cluster to run on.
    reuse : directories with results of earlier runs of the same code and packages; those of the same method, options
        and task are taken from there.
    timeout_s : seconds after which a run is ended and kept as a failed one; compiling kernels does not count.
    memory_gib : memory that the process of a run may allocate, GiB; Linux only.
    resume : continue a run that was interrupted, or start it where nothing was started.
    trust : whether code may run that the suite file or, with `resume`, the directory names; or a function that answers
        a question in words.  What `methods` names is trusted.
    progress : show a progress bar on standard error.
    message : is called with a line of text about a seed that was drawn or a number of workers, before anything runs.

    Returns
    -------
    The results; failed runs are among them.

    Raises
    ------
    BadInput : an unknown suite, method or vessel, missing measured data, a limit or a directory that cannot be used;
        found before anything is written.  Later, where the machine is at fault (a full disk, a lost cluster): what is
        finished is kept, and `resume` goes on.  Also code that is not trusted.
    """
    from ..bench.cluster import cluster
    from ..bench.execution import UNLIMITED, Limits
    from ..bench.kinds.base import RunSelection
    from ..bench.pool import processes, worker_count
    from ..bench.store import MANIFEST
    from ..bench.suites import check_trust

    folder = Path(directory)
    given = RunSelection(suite or QUICK, tuple(methods), tuple(vessels), seeds, seed)
    resume = resume and _started(folder)
    if resume:
        stored = _stored_selection(folder)
        asked = (suite, given.methods, given.vessels, seeds) != (None, (), (), None)
        given = replace(given if asked else stored, seed=stored.seed if seed is None else seed)
        check_trust([name for name in given.methods if name not in methods], folder / MANIFEST, trust)
    limits = Limits(timeout_s, memory_gib)
    limits.check()
    if limits != UNLIMITED and scheduler:
        hint = "dask has its own: `dask worker --memory-limit`, and `--lifetime` with `--lifetime-restart`"
        raise BadInput("--timeout and --memory are for worker processes of this machine", hint=hint)
    if message is not None and not scheduler and (jobs or 0) > worker_count(jobs):
        message(f"{jobs} workers asked for, {worker_count(jobs)} processors here: {worker_count(jobs)} workers")
    place = cluster(scheduler) if scheduler else processes(jobs)
    earlier = [*map(Path, reuse)]
    store = _execute(folder, given, resume, trust, earlier, place, not scheduler, limits, progress, message)
    return SuiteResults(store.directory, store.manifest, tuple(run["row"] for run in store.runs))


@typed
def load_results(directory: str | PathLike[str]) -> SuiteResults:
    """The stored results of a suite, complete or not.

    Raises
    ------
    BadInput : the directory holds no run of a suite, or a file in it is damaged.
    """
    from ..bench.journal import RUNS, read_runs
    from ..bench.store import read_manifest, stored_kind, tables

    folder = Path(directory)
    manifest = read_manifest(folder)
    form = stored_kind(manifest).tables
    _, rows = tables(read_runs(folder / RUNS, form), form)[form.wide_file]
    return SuiteResults(folder, manifest, tuple(rows))


@typed
def leaderboard(results: SuiteResults | str | PathLike[str]) -> Leaderboard:
    """The leaderboard of a suite: methods ranked by parameter error and by prediction of held-out records.

    Parameters
    ----------
    results : what `run_suite` or `load_results` gave, or a directory of results.

    Returns
    -------
    Tables: `overall`, `cells` (a row a cell and method), `failures`.

    Raises
    ------
    BadInput : no run is finished, or the suite ranks no identification methods.
    """
    from ..bench.kinds import IDENTIFICATION
    from ..bench.store import read_tables
    from ..reporting.leaderboard.board import build

    found = results if isinstance(results, SuiteResults) else load_results(results)
    if found.manifest.get("kind", IDENTIFICATION) != IDENTIFICATION:
        hint = "write_report (helmbench report) writes its rates"
        raise BadInput(f"suite {found.suite} ranks no identification methods", file=found.directory, hint=hint)
    if not found.rows:
        raise BadInput("no run is finished yet", file=found.directory, hint="continue with run_suite(..., resume=True)")
    return build(*read_tables(found.directory))


@typed
def compare_results(first: str | PathLike[str], second: str | PathLike[str]) -> Changes:
    """What changed between two folders of results: paired by problem and method, with intervals.

    Parameters
    ----------
    first, second : directories of results of identification suites.

    Returns
    -------
    Ratios second / first of errors and times with 95 % intervals and p-values; runs that ended otherwise.

    Raises
    ------
    BadInput : a directory holds no finished run, or they share none, or a suite identifies nothing.
    """
    from ..bench.kinds import IDENTIFICATION
    from ..bench.store import read_manifest, read_tables
    from ..reporting.leaderboard.comparing import changes

    for folder in (first, second):
        if read_manifest(Path(folder)).get("kind", IDENTIFICATION) != IDENTIFICATION:
            raise BadInput("holds no results of an identification suite", file=Path(folder))
    found = changes(read_tables(Path(first)), read_tables(Path(second)))
    if not found.rows:
        raise BadInput(f"shares no run with {first}", file=Path(second), hint="compare results of the same suite")
    return found


@typed
def merge_results(
    source: str | PathLike[str],
    target: str | PathLike[str],
    *,
    sample: int | None = None,
    seed: int | None = None,
    trust: Trust = False,
) -> MergeCounts:
    """Check results from elsewhere and add them to a directory of the same suite.

    Parameters
    ----------
    source, target : directories of results; `target` is added to.
    sample : number of added runs that are computed again; None: 5 %, at least 30, all where there are fewer.
    seed : seed from which they are drawn; None: a new one, which the result states.
    trust : whether code may run that the directories name; or a function that answers a question in words.

    Returns
    -------
    How many runs were added, were known already, and were computed again; what could not be; the seed of the sample.

    Raises
    ------
    BadInput : another suite or version, a run that is not planned, or a score that is not found again; nothing is
        written then.
    """
    from ..bench.merging import merge

    return merge(Path(source), Path(target), sample, seed, trust)


def _started(directory: Path) -> bool:
    from ..bench.store import MANIFEST
    from ..models.folders import check_regular

    return check_regular(directory / MANIFEST)


def _stored_selection(directory: Path) -> RunSelection:
    from ..bench.kinds.base import RunSelection
    from ..bench.store import read_manifest

    stored = read_manifest(directory).get("selection", {})
    lists = {name: tuple(stored.get(name) or ()) for name in ("methods", "vessels")}
    return RunSelection(stored.get("suite", "quick"), **lists, seeds=stored.get("seeds"), seed=stored.get("seed"))


def _execute(
    directory: Path,
    selection: RunSelection,
    resume: bool,
    trust: Trust,
    reuse: Sequence[Path],
    place: AbstractContextManager[Pool],
    here: bool,
    limits: Limits,
    progress: bool,
    message: Callable[[str], object] | None,
) -> Store:
    """Run what is not stored yet; whatever is wrong with the input is found before anything is written."""
    from tqdm import tqdm

    from ..bench import runner
    from ..bench.kinds import kind_of
    from ..bench.merging import check_folders, take
    from ..bench.store import check_vacant
    from ..bench.suites import check_trust, load_suite

    if not resume:
        check_vacant(directory)
    suite = load_suite(selection.suite)
    check_trust(suite.texts, selection.suite, trust)
    kind = kind_of(suite.kind)
    selection = kind.with_seed(suite, selection)
    specs = kind.plan(suite, selection)
    if selection.seed is not None and message is not None:
        message(f"seed {selection.seed} (--seed {selection.seed} draws the same cases)")
    if here:
        kind.check(specs)
    check_folders(reuse, kind)
    with place as pool:
        opened = runner.resume_store(directory, suite, specs) if resume else None
        with opened or runner.open_store(directory, suite, selection, specs) as store:
            taken = take(specs, store, reuse)
            if reuse and message is not None:
                message(f"{taken} of {len(specs)} runs are taken from earlier results")
            done = sum(spec.key in store.finished for spec in specs)
            with tqdm(total=len(specs), initial=done, unit="run", disable=not progress, file=sys.stderr) as bar:
                runner.run(specs, store, pool, _watch(bar, kind), limits)
    return store


def _watch(bar: Any, kind: Kind) -> Callable[[dict[str, Any]], object]:
    """Moves the bar on by a finished run, with the number of failures; a failure is told above the bar at once."""
    failures: list[str] = []

    def watch(finished: dict[str, Any]) -> None:
        if finished["row"]["status"] == "failed":
            told = kind.describe(finished["row"])
            if not bar.disable and told not in failures:
                bar.write(visible(f"failed: {told}"), file=sys.stderr)
            failures.append(told)
            bar.set_postfix_str(f"{len(failures)} failed", refresh=False)
        bar.update()

    return watch
