"""What an identification suite runs: every method on every task."""

from __future__ import annotations

import hashlib
import json
from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass, replace
from functools import cached_property, lru_cache
from itertools import product
from typing import TYPE_CHECKING, Any

from ....models.errors import BadInput
from ....models.memory import SIMULATED_SAMPLE, require_memory
from ....models.model import list_vessels, resolve
from ....models.suggestions import suggestion
from ..base import Selection, limited
from .problems import Task

if TYPE_CHECKING:
    from ...suites import Suite
    from .suite import Entry

VESSEL_GROUPS = {"all": (True, False), "3dof": (True,), "response": (False,)}
"""Names of groups of vessels in a suite file -> whether they have three degrees of freedom."""

ADDED = {"held_out_noise": "none", "held_out_disturbance": "none", "held_out_speed": 1.0, "held_out_dataset": None}
"""Fields of a task that count in a run's key only where they are not these values: older runs keep their keys."""
METHOD_GROUPS = {
    "all": ("grey box", "black box", "hybrid", "floor"),
    "identification": ("grey box",),
    "learners": ("black box", "hybrid", "floor"),
}
"""Names of groups of methods in a suite file -> the kinds of method (`methods.base.KINDS`) that they hold."""


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
        return self._key

    @cached_property
    def _key(self) -> str:
        return hashlib.sha256(self.text().encode()).hexdigest()[:20]

    def text(self, **changed: str) -> str:
        """What is run, as JSON."""
        own = {"suite": self.suite, "method": self.method, "variant": self.variant, "maker": self.maker}
        task = {name: value for name, value in vars(self.task).items() if ADDED.get(name, ...) != value}
        facts = own | {"task": task} | changed
        return json.dumps(facts, sort_keys=True, separators=(",", ":"))

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
            "held_out": task.held_out_text,
            "noise": task.noise,
            "disturbance": task.disturbance,
            "thinning": task.thinning,
            "length": task.length,
            "seed": task.seed,
        }


def plan(suite: Suite, selection: Selection | None = None) -> list[RunSpec]:
    """Every run of a suite, without repetitions, in the suite's order.

    Raises `BadInput` for unknown methods, vessels or models, and where nothing is left to run.
    """
    selection = selection or Selection(suite.name)
    _check_vessels(suite, selection)
    specs = limited((s for entry in suite.entries for s in _entry_specs(suite.name, entry, selection)), suite.name)
    if not specs:
        raise BadInput("nothing to run", file=f"suite {suite.name}", hint="the filters leave no row of it")
    specs = list(dict.fromkeys(specs))
    names = Counter(tuple(spec.row_key().values()) for spec in specs)
    twice = next((name for name, count in names.items() if count > 1), None)
    if twice:
        raise BadInput(f"two different runs have the same row: {' '.join(map(str, twice))}", file=f"suite {suite.name}")
    return specs


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
    from ....methods.registry import make

    method = make(maker)
    options = [part.strip() for part in maker.split(",")[1:] if not part.strip().startswith("variant=")]
    return ",".join([type(method).name, *options]), method.variant


def _entry_methods(entry: Entry, selection: Selection) -> list[str]:
    own = [name for text in entry.methods for name in (_methods_of(text) if text in METHOD_GROUPS else [text])]
    if not selection.methods:
        return own
    for name in selection.methods:
        _named(name)
    return [name for name in selection.methods if name in own or entry.open]


def _methods_of(group: str) -> list[str]:
    from ....methods.registry import methods

    return [name for name, cls in methods().items() if cls.kind in METHOD_GROUPS[group]]


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
    from ....datasets.generator import sampling
    from ....datasets.manoeuvres import steps

    source = vessel if model == "own" else model
    suggested = {} if entry.dataset else resolve(vessel).suite
    train = train or tuple(suggested.get("train", ()))
    held_out = held_out or tuple(suggested.get("held_out", ()))
    if not train or not held_out:
        hint = "add them to its suite block"
        raise BadInput("the suite needs train and held_out", file=f"vessel {vessel}", hint=hint)
    if entry.euler:
        from ....datasets.manoeuvres import EULER

        train = tuple(text if text.endswith(EULER) else text + EULER for text in train)
    if not entry.dataset:
        dt, duration = sampling(resolve(vessel), entry.duration_s, entry.dt_s)
        require_memory(SIMULATED_SAMPLE * steps(dt, duration), f"{steps(dt, duration)} samples of {vessel}")
    return Task(
        vessel=vessel,
        source=source,
        model=resolve(source).family,
        train=train,
        held_out=held_out,
        measured=entry.dataset is not None,
        duration_s=entry.duration_s,
        dt_s=entry.dt_s,
        held_out_noise=entry.held_out_noise,
        held_out_disturbance=entry.held_out_disturbance,
        held_out_speed=entry.held_out_speed,
        held_out_dataset=entry.held_out_dataset,
    )


def _entry_vessels(entry: Entry) -> list[str]:
    if entry.dataset:
        return [entry.dataset]
    found = [vessel for name in entry.vessels for vessel in (_group(name) if name in VESSEL_GROUPS else [name])]
    return list(dict.fromkeys(found))


@lru_cache(maxsize=8)
def _group(name: str) -> tuple[str, ...]:
    return tuple(vessel for vessel in list_vessels() if resolve(vessel).is_3dof in VESSEL_GROUPS[name])


def _check_vessels(suite: Suite, selection: Selection) -> None:
    known = {vessel for entry in suite.entries for vessel in _entry_vessels(entry)}
    for vessel in selection.vessels:
        if vessel not in known:
            hint = suggestion(vessel, known, f"it has {', '.join(sorted(known))}")
            raise BadInput(f"suite {suite.name} has no vessel {vessel!r}", hint=hint)
