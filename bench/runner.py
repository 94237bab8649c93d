"""Runner: `plan` enumerates what a suite holds, `run` executes it and keeps every finished run at once."""

from __future__ import annotations

import hashlib
import json
import sys
import time
import warnings
from collections import Counter
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import asdict, dataclass, replace
from functools import lru_cache
from itertools import product
from pathlib import Path
from typing import TYPE_CHECKING, Any, Protocol

from ..models.errors import BadInput
from ..models.model import list_vessels, resolve
from .environment import environment
from .kinds.identification.problems import HELD_OUT_SEED, Problem, Task, problem
from .store import MANIFEST, Store
from .suites import GROUPS, Entry, Suite

if TYPE_CHECKING:
    from .pool import Pool

WARM_SAMPLES = 60
LISTED = ("method", "variant", "vessel", "model", "train", "noise", "disturbance", "seed")
"""Columns by which a failure is told."""
_WARMED: set[tuple[str, str]] = set()


@dataclass(frozen=True)
class RunSpec:
    """One row to run: a task, and the method that `maker` makes (`methods.registry.make`).

    `method` and `variant` are what the tables call it.
    """

    suite: str
    method: str
    variant: str
    maker: str
    task: Task

    @property
    def key(self) -> str:
        """Identifier that is the same in every process and session."""
        text = json.dumps(asdict(self), sort_keys=True, separators=(",", ":"))
        return hashlib.sha256(text.encode()).hexdigest()[:20]

    def row_key(self) -> dict[str, Any]:
        """The key columns of the tables."""
        task = self.task
        return {
            "suite": self.suite,
            "method": self.method,
            "variant": self.variant,
            "vessel": task.vessel,
            "model": task.model,
            "train": "+".join(task.train),
            "held_out": "+".join(task.held_out),
            "noise": task.noise,
            "disturbance": task.disturbance,
            "thinning": task.thinning,
            "length": task.length,
            "seed": task.seed,
        }


class Spec(Protocol):
    """What a kind of suite plans: it can be told apart, named in a row, and sent to a worker."""

    @property
    def key(self) -> str: ...

    def row_key(self) -> dict[str, Any]: ...


@dataclass(frozen=True)
class Selection:
    """What of a suite is run; empty and None mean what the suite says.

    `methods` not named by an open entry are added to it; `vessels` also selects measured sets by their names.
    `seed` is what a suite that draws its cases starts from.
    """

    suite: str = "quick"
    methods: tuple[str, ...] = ()
    vessels: tuple[str, ...] = ()
    seeds: int | None = None
    seed: int | None = None


def plan(suite: Suite, selection: Selection | None = None) -> list[RunSpec]:
    """Every run of a suite, without repetitions, in the suite's order.

    Raises `BadInput` for unknown methods, vessels or models, and where nothing is left to run.
    """
    selection = selection or Selection(suite.name)
    _check_vessels(suite, selection)
    specs = [spec for entry in suite.entries for spec in _entry_specs(suite.name, entry, selection)]
    if not specs:
        raise BadInput("nothing to run", file=f"suite {suite.name}", hint="the filters leave no row of it")
    specs = list(dict.fromkeys(specs))
    names = Counter(tuple(spec.row_key().values()) for spec in specs)
    twice = next((name for name, count in names.items() if count > 1), None)
    if twice:
        raise BadInput(f"two different runs have the same row: {' '.join(map(str, twice))}", file=f"suite {suite.name}")
    return specs


def run(
    specs: Sequence[Spec],
    store: Store,
    pool: Pool,
    watch: Callable[[dict[str, Any]], object] | None = None,
    work: Callable[[Any], dict[str, Any]] | None = None,
) -> None:
    """Execute what `store` does not hold yet, keep each run as it ends, then write the tables.

    `watch` is called with every finished run; `work` is `execute` of the suite's kind (default: the one here).
    The caller warms the kernels first (`warm`).
    """
    todo: list[Any] = [spec for spec in specs if spec.key not in store.finished]
    for spec, future in pool.outcomes(work or execute, todo):
        error = future.exception()
        finished = future.result() if error is None else lost(spec, error)
        store.append(finished)
        if watch is not None:
            watch(finished)
    store.write_tables()


def settled(suite: Suite, selection: Selection) -> Selection:
    """The selection as it is: nothing is drawn anew.  Raises `BadInput` where a seed is asked for."""
    if selection.seed is not None:
        raise BadInput("--seed is for suites that draw their cases", hint=f"suite {suite.name} has fixed seeds")
    return selection


def check(specs: Iterable[RunSpec]) -> None:
    """Raise `BadInput` where a measured record that the runs need is missing on this machine."""
    from ..datasets.measured import load

    tasks = [spec.task for spec in specs if spec.task.measured]
    for name, stem in dict.fromkeys((task.vessel, stem) for task in tasks for stem in (*task.train, *task.held_out)):
        load(name, stem)


def facts(suite: Suite, specs: Sequence[RunSpec]) -> dict[str, Any]:
    """What the manifest tells beside what every suite does."""
    return {"seeds": sorted({spec.task.seed for spec in specs}), "held_out_seed": HELD_OUT_SEED}


def open_store(
    directory: str | Path,
    suite: Suite,
    selection: Selection,
    specs: Sequence[Any],
    told: Mapping[str, Any] | None = None,
) -> Store:
    """A new store for these runs, described by its manifest; `told` are the `facts` of the suite's kind
    (default: those of the one here)."""
    manifest = {
        "suite": suite.name,
        "title": suite.title,
        "suite_digest": suite.digest,
        "version": code_version(),
        "selection": asdict(selection),
        "planned": len(specs),
        "plan_digest": plan_digest(specs),
        **(facts(suite, specs) if told is None else told),
        "threads_per_worker": 1,
        **environment(),
    }
    return Store.create(directory, manifest)


def resume_store(directory: str | Path, suite: Suite, specs: Sequence[Spec]) -> Store:
    """The store of a started run, refused where it was made from another suite, selection or version."""
    store = Store.resume(directory)
    expected = {
        "suite": suite.name,
        "version": code_version(),
        "suite_digest": suite.digest,
        "plan_digest": plan_digest(specs),
    }
    named = {"suite_digest": "the suite's file", "plan_digest": "the selection of methods, vessels and seeds"}
    for name, value in expected.items():
        if store.manifest.get(name) != value:
            store.close()
            raise BadInput(
                f"cannot be resumed: {named.get(name, name)} differs from the one it was started with",
                file=Path(directory) / MANIFEST,
                hint="start again in a new directory",
            )
    return store


def code_version() -> str:
    """Version of the installed package, with a digest of its sources."""
    return f"{environment()['packages']['helmbench']}+{_source_digest()}"


def plan_digest(specs: Iterable[Spec]) -> str:
    """Digest of the set of runs."""
    return hashlib.sha256("".join(sorted(spec.key for spec in specs)).encode()).hexdigest()[:16]


def execute(spec: RunSpec) -> dict[str, Any]:
    """Fit, score and time one run: `{"key", "row", "parameters"}` with built-in types only.

    Whatever goes wrong inside becomes the row's status and error.
    """
    return guarded(spec, lambda row: _fit_and_score(spec, row))


def guarded(spec: Spec, work: Callable[[dict[str, Any]], list[dict[str, Any]]]) -> dict[str, Any]:
    """The finished run of a spec whose `work` fills in its row and returns its further rows."""
    from ..models.errors import CannotFit, FitFailed

    row: dict[str, Any] = spec.row_key() | {"status": "failed", "error": None}
    parameters: list[dict[str, Any]] = []
    with quiet():
        try:
            parameters = work(row)
            row["status"] = "ok"
        except CannotFit as reason:
            row |= {"status": "not_applicable", "error": one_line(reason)}
        except (FitFailed, BadInput) as reason:
            row["error"] = one_line(reason)
        except Exception as error:  # a method's own fault is a row, too
            row["error"] = one_line(f"{type(error).__name__}: {error}")
    return {"key": spec.key, "row": row, "parameters": parameters}


def describe(row: Mapping[str, Any]) -> str:
    """A failed run in words."""
    variant = "" if row["variant"] == "corrected" else f" ({row['variant']})"
    return f"{row['method']}{variant} on {row['vessel']} as {row['model']}, noise {row['noise']}: {row['error']}"


def lost(spec: Spec, error: BaseException) -> dict[str, Any]:
    """The finished run of a task whose worker gave nothing back."""
    reason = one_line(f"worker process died ({type(error).__name__}: {error})")
    return {"key": spec.key, "row": spec.row_key() | {"status": "failed", "error": reason}, "parameters": []}


def warm(specs: Iterable[RunSpec]) -> None:
    """Compile, in this process, every kernel that the runs will need, so that workers only load them."""
    first = {(spec.task.vessel, spec.task.source, spec.maker): spec for spec in reversed(list(specs))}
    with quiet():
        for spec in (first[key] for key in sorted(first)):
            _attempt(lambda spec=spec: _warm_fit(spec, problem(spec.task)))


def one_line(message: object, most: int = 400) -> str:
    """A message without line breaks, cut to a sensible length."""
    text = " ".join(str(message).split())
    return text if len(text) <= most else text[: most - 3] + "..."


# enumerating


def _entry_specs(suite: str, entry: Entry, selection: Selection) -> Iterator[RunSpec]:
    methods = _entry_methods(entry, selection)
    for task in _tasks(entry, selection) if methods else ():
        for maker in methods:
            yield _spec(suite, maker, task)


def _spec(suite: str, maker: str, task: Task) -> RunSpec:
    name, variant = _named(maker)
    return RunSpec(suite, name, variant, maker, task)


@lru_cache(maxsize=256)
def _named(maker: str) -> tuple[str, str]:
    """What the tables call a method: its identifier with its options, and its variant; checks that it can be made."""
    from ..methods.registry import make

    method = make(maker)
    options = [part.strip() for part in maker.split(",")[1:] if not part.strip().startswith("variant=")]
    return ",".join([type(method).name, *options]), method.variant


def _entry_methods(entry: Entry, selection: Selection) -> list[str]:
    from ..methods.registry import methods

    own = [name for text in entry.methods for name in (methods() if text == "all" else [text])]
    if not selection.methods:
        return own
    for name in selection.methods:
        _named(name)
    return [name for name in selection.methods if name in own or entry.open]


def _tasks(entry: Entry, selection: Selection) -> Iterator[Task]:
    sets = product(_entry_vessels(entry), entry.models, entry.train or ((),), entry.held_out or ((),))
    for vessel, model, train, held_out in sets:
        if selection.vessels and vessel not in selection.vessels:
            continue
        bare = _task(entry, vessel, model, train, held_out)
        for conditions in product(entry.thinning, entry.length, entry.noise, entry.disturbance):
            seeds = (selection.seeds or entry.seeds) if conditions[2:] != ("none", "none") else 1
            settings = dict(zip(("thinning", "length", "noise", "disturbance"), conditions, strict=True))
            for seed in range(seeds):
                yield replace(bare, seed=seed, **settings)


def _task(entry: Entry, vessel: str, model: str, train: tuple[str, ...], held_out: tuple[str, ...]) -> Task:
    """A task of an entry, in calm water, without noise and of the first seed."""
    source = vessel if model == "own" else model
    suggested = {} if entry.dataset else resolve(vessel).suite
    train = train or tuple(suggested.get("train", ()))
    held_out = held_out or tuple(suggested.get("held_out", ()))
    if not train or not held_out:
        hint = "add them to its suite block"
        raise BadInput("the suite needs train and held_out", file=f"vessel {vessel}", hint=hint)
    if entry.euler:
        from ..datasets.manoeuvres import EULER

        train = tuple(text if text.endswith(EULER) else text + EULER for text in train)
    return Task(
        vessel=vessel,
        source=source,
        model=resolve(source).family,
        train=train,
        held_out=held_out,
        measured=entry.dataset is not None,
        duration_s=entry.duration_s,
        dt_s=entry.dt_s,
    )


def _entry_vessels(entry: Entry) -> list[str]:
    if entry.dataset:
        return [entry.dataset]
    found = [vessel for name in entry.vessels for vessel in (_group(name) if name in GROUPS else [name])]
    return list(dict.fromkeys(found))


@lru_cache(maxsize=8)
def _group(name: str) -> tuple[str, ...]:
    wanted = {"all": (True, False), "3dof": (True,), "response": (False,)}[name]
    return tuple(vessel for vessel in list_vessels() if resolve(vessel).is_3dof in wanted)


def _check_vessels(suite: Suite, selection: Selection) -> None:
    known = {vessel for entry in suite.entries for vessel in _entry_vessels(entry)}
    for vessel in selection.vessels:
        if vessel not in known:
            raise BadInput(f"suite {suite.name} has no vessel {vessel!r}", hint=f"it has {', '.join(sorted(known))}")


# executing


def _fit_and_score(spec: RunSpec, row: dict[str, Any]) -> list[dict[str, Any]]:
    """Fill in the row; returns the rows of its parameters."""
    from ..estimation.prediction import prediction_scores
    from ..methods.registry import make
    from .scores import parameter_rows, parameter_scores

    task = problem(spec.task)
    _warm_fit(spec, task)
    row["n_samples"] = task.n_samples
    method = make(spec.maker)
    with measured_cost(row):
        estimate = method.fit(list(task.train), task.model)
    parameters = parameter_rows(task.model, task.truth, estimate)
    row |= parameter_scores(parameters) | prediction_scores(estimate.model, task.held_out, estimate.predictor)
    if not estimate.converged:
        row["error"] = one_line(f"not converged: {estimate.message or 'no reason given'}")
    return parameters


@contextmanager
def measured_cost(row: dict[str, Any]) -> Iterator[None]:
    """Wall time, CPU time and peak memory of what is done inside, entered in the row however it ends."""
    peak = reset_peak_memory()
    wall, cpu = time.perf_counter(), time.process_time()
    try:
        yield
    finally:
        row |= {"wall_s": time.perf_counter() - wall, "cpu_s": time.process_time() - cpu}
        row["peak_memory_mib"] = peak()


def reset_peak_memory() -> Callable[[], float | None]:
    """Start a measurement of this process's peak resident memory; the result gives it in MiB.

    On Linux the peak is reset first, so that it belongs to what ran since (interpreter and libraries included);
    elsewhere it is the peak since the process started, and None where the system does not tell.
    """
    status = Path("/proc/self/status")
    try:
        Path("/proc/self/clear_refs").write_text("5")
        status.read_bytes()
    except OSError:
        return _peak_since_start
    return lambda: next(int(line.split()[1]) for line in status.read_text().splitlines() if "VmHWM" in line) / 1024.0


def _peak_since_start() -> float | None:
    try:
        import resource
    except ImportError:
        return None
    peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    return peak / (1024.0**2 if sys.platform == "darwin" else 1024.0)


def _warm_fit(spec: RunSpec, task: Problem) -> None:
    """Fit and score a few samples, untimed, once per process, method and model: timed fits then compile nothing."""
    from ..estimation.prediction import prediction_scores
    from ..methods.registry import make

    if (spec.maker, spec.task.source) in _WARMED:
        return
    _WARMED.add((spec.maker, spec.task.source))
    short = [record.slice(0, WARM_SAMPLES) for record in task.train]

    def action() -> None:
        estimate = make(spec.maker).fit(short, task.model)
        prediction_scores(estimate.model, task.held_out[:1], estimate.predictor)

    _attempt(action)


def _attempt(action: Callable[[], object]) -> None:
    """Do something whose failure will show, with its reason, when it is done in earnest."""
    try:
        action()
    except Exception as error:
        warnings.warn(one_line(error), RuntimeWarning, stacklevel=2)


@contextmanager
def quiet() -> Iterator[None]:
    """One BLAS thread and no numerical warnings: bad numbers are judged by the scores."""
    import numpy as np
    from threadpoolctl import threadpool_limits

    with threadpool_limits(1), np.errstate(all="ignore"), warnings.catch_warnings():
        warnings.simplefilter("ignore")
        yield


@lru_cache(maxsize=1)
def _source_digest() -> str:
    rooms = Path(__file__).resolve().parents[1]
    digest = hashlib.sha256()
    for folder in ("models", "datasets", "estimation", "methods", "diagnosis", "bench"):
        for path in sorted((rooms / folder).rglob("*")):
            if path.suffix in (".py", ".yaml"):
                digest.update(path.relative_to(rooms).as_posix().encode() + b"\0" + path.read_bytes())
    return digest.hexdigest()[:12]
