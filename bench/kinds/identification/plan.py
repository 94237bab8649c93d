"""What an identification suite runs: every method on every task."""

from __future__ import annotations

import hashlib
import json
from collections import Counter
from collections.abc import Iterator
from dataclasses import asdict, dataclass, replace
from functools import cached_property, lru_cache
from itertools import product
from pathlib import Path
from typing import Any

from ....datasets.generator import sampling, suggested
from ....datasets.manoeuvres import EULER, steps
from ....datasets.measured import missing_files
from ....methods.registry import make, methods
from ....models.errors import BadInput
from ....models.memory import SIMULATED_SAMPLE, require_memory
from ....models.model import list_vessels, resolve
from ....models.suggestions import suggestion
from ..base import RunSelection, Suite, limited
from .own import OwnVessel, digest, is_file_name, located, ship_of
from .problems import Task, check_task
from .suite import RunsEntry

VESSEL_GROUPS = {"all": (True, False), "3dof": (True,), "response": (False,)}
"""Names of groups of vessels in a suite file -> whether they have three degrees of freedom."""

OF_ENTRIES = ("duration_s", "dt_s", "held_out_noise", "held_out_disturbance", "held_out_speed", "held_out_dataset")
"""Fields of a task that are those of its entry."""
AS_MEASURED = "as measured"
"""Noise and disturbance of measured records in the tables: none was added, which does not say that there is none."""
METHOD_GROUPS = {
    "all": ("grey box", "black box", "hybrid", "floor"),
    "identification": ("grey box",),
    "learners": ("black box", "hybrid", "floor"),
}
"""Names of groups of methods in a suite file -> the kinds of method (`methods.base.KINDS`) of the class of seconds that
they hold."""


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

    @cached_property
    def key(self) -> str:
        """Identifier that is the same in every process and session."""
        return hashlib.sha256(self.text().encode()).hexdigest()[:20]

    def text(self, **changed: str) -> str:
        """What is run, as JSON."""
        return json.dumps(asdict(self) | changed, sort_keys=True, separators=(",", ":"))

    def row_key(self) -> dict[str, Any]:
        """The key columns of the tables."""
        return {"suite": self.suite, "method": self.method, "variant": self.variant, **task_key(self.task)}


def task_key(task: Task) -> dict[str, Any]:
    """The key columns of the tables that say which task it is."""
    return {
        "vessel": task.vessel,
        "model": model_text(task),
        "train": task.train_text,
        "held_out": task.held_out_text,
        "noise": as_measured(task.noise) if task.measured else task.noise,
        "disturbance": AS_MEASURED if task.measured else task.disturbance,
        "thinning": task.thinning,
        "length": task.length,
        "seed": task.seed,
    }


def as_measured(noise: str) -> str:
    """The noise of measured records as the tables name it: theirs, and the channels that were taken away."""
    return AS_MEASURED + noise.removeprefix("none")


def model_text(task: Task) -> str:
    """The fitted family, and what is wrong with it: constants of another ship, changed constants, lacking terms."""
    source = Path(task.source).stem if is_file_name(task.source) else task.source
    parts = [task.model]
    if task.source not in (task.model, task.ship) and not task.measured:
        parts.append(f"of {source}")
    parts += [f"with {factor:g} {name}" for name, factor in task.constants]
    parts += [f"without {extension}" for extension, _ in task.terms]
    return " ".join(parts)


def plan(suite: Suite, selection: RunSelection | None = None) -> list[RunSpec]:
    """Every run of a suite, without repetitions, in the suite's order.

    Raises `BadInput` for unknown methods, vessels or models, and where nothing is left to run.
    """
    selection = selection or RunSelection(suite.name)
    _check_vessels(suite, selection)
    specs = limited((s for entry in suite.entries for s in _entry_specs(suite, entry, selection)), suite.name)
    if not specs:
        raise BadInput("nothing to run", file=f"suite {suite.name}", hint="the filters leave no row of it")
    specs = list(dict.fromkeys(specs))
    names = Counter(tuple(spec.row_key().values()) for spec in specs)
    twice = next((name for name, count in names.items() if count > 1), None)
    if twice:
        raise BadInput(f"two different runs have the same row: {' '.join(map(str, twice))}", file=f"suite {suite.name}")
    return specs


def _entry_specs(suite: Suite, entry: RunsEntry, selection: RunSelection) -> Iterator[RunSpec]:
    methods = _entry_methods(entry, selection)
    if entry.optional and not _present(entry, suite.folder):
        return
    for task in _tasks(entry, selection, suite.folder) if methods else ():
        for maker in methods:
            yield RunSpec(suite.name, *_named(maker), maker, task)


def _present(entry: RunsEntry, folder: Path) -> bool:
    """Whether the records of an optional entry are on this machine."""
    if entry.dataset:
        return not any(missing_files(name) for name in (entry.dataset, entry.held_out_dataset) if name)
    groups = (*entry.records.train, *entry.records.held_out) if entry.records else ()
    return all(Path(located(text, folder)).is_file() for group in groups for text in group)


@lru_cache(maxsize=256)
def _named(maker: str) -> tuple[str, str]:
    """What the tables call a method: its identifier with its options, and its variant; checks that it can be made."""
    method = make(maker)
    options = [part.strip() for part in maker.split(",")[1:] if not part.strip().startswith("variant=")]
    return ",".join([type(method).name, *options]), method.variant


def _entry_methods(entry: RunsEntry, selection: RunSelection) -> list[str]:
    own = [name for text in entry.methods for name in (_methods_of(text) if text in METHOD_GROUPS else [text])]
    if not selection.methods:
        return own
    for name in selection.methods:
        _named(name)
    return [name for name in selection.methods if name in own or entry.open]


def _methods_of(group: str) -> list[str]:
    return [name for name, cls in methods().items() if cls.kind in METHOD_GROUPS[group] and not cls.minutes]


def _tasks(entry: RunsEntry, selection: RunSelection, folder: Path) -> Iterator[Task]:
    own = entry.records or entry
    asked = selection.vessels
    ships = [s for s in _entry_ships(entry, folder) if not asked or s.id in asked or s.file in asked]
    for ship in [*ships, *_joining(entry, selection)]:
        for model, train, held_out in product(entry.models, own.train or ((),), own.held_out or ((),)):
            bare = _task(entry, ship, model, train, held_out, folder)
            for conditions in product(entry.thinning, entry.length, entry.noise, entry.disturbance):
                seeds = (selection.seeds or entry.seeds) if conditions[2:] != ("none", "none") else 1
                settings = dict(zip(("thinning", "length", "noise", "disturbance"), conditions, strict=True))
                found = [replace(bare, seed=seed, **settings) for seed in range(seeds)]
                if not bare.measured:
                    check_task(found[0])
                yield from found


def _task(
    entry: RunsEntry, ship: OwnVessel, model: str, train: tuple[str, ...], held_out: tuple[str, ...], folder: Path
) -> Task:
    """A task of an entry, in calm water, without noise and of the first seed."""
    measured = entry.dataset is not None or entry.records is not None
    source = ship.text if model == "own" else located(model, folder) if is_file_name(model) else model
    sail = {} if measured else suggested(resolve(ship.text))
    train, held_out = train or tuple(sail.get("train", ())), held_out or tuple(sail.get("held_out", ()))
    if not train or not held_out:
        hint = "add them to its suite block"
        raise BadInput("the suite needs train and held_out", file=f"vessel {ship.text}", hint=hint)
    if entry.records:
        train, held_out = (tuple(located(text, folder) for text in texts) for texts in (train, held_out))
        shared = set(train) & set(held_out)
        if shared:
            raise BadInput("is a training and a held-out record of one entry", file=min(shared))
    if entry.euler:
        train = tuple(text if text.endswith(EULER) else text + EULER for text in train)
    if not measured:
        _require_memory(ship, entry)
    named = [text for text in (ship.file, source) if text and is_file_name(text)]
    return Task(
        vessel=ship.id,
        source=source,
        model=resolve(source).family,
        train=train,
        held_out=held_out,
        measured=measured,
        vessel_file=ship.file,
        own_records=entry.records is not None,
        positive_rudder=entry.records.positive_rudder if entry.records else None,
        constants=tuple(sorted(entry.constants.items())),
        terms=tuple((name, tuple(sorted(values.items()))) for name, values in sorted(entry.terms.items())),
        digest=digest([*named, *(train + held_out if entry.records else ())]),
        **{name: getattr(entry, name) for name in OF_ENTRIES},
    )


def _require_memory(ship: OwnVessel, entry: RunsEntry) -> None:
    dt, duration = sampling(resolve(ship.text), entry.duration_s, entry.dt_s)
    require_memory(SIMULATED_SAMPLE * steps(dt, duration), f"{steps(dt, duration)} samples of {ship.id}")


def _entry_ships(entry: RunsEntry, folder: Path) -> list[OwnVessel]:
    if entry.dataset or entry.records:
        return [OwnVessel(entry.dataset or (entry.records.ship if entry.records else ""))]
    texts = [vessel for name in entry.vessels for vessel in (_group(name) if name in VESSEL_GROUPS else [name])]
    return [ship_of(text, folder) for text in dict.fromkeys(texts)]


def _joining(entry: RunsEntry, selection: RunSelection) -> list[OwnVessel]:
    """Ships of the user's own that an entry takes beside those that it names: simulated ones like any of these.

    A ship without windage stays out of the wind.
    """
    if entry.dataset or entry.records:
        return []
    asked = [ship_of(name, Path()) for name in selection.vessels if is_file_name(name)]
    texts = [name for name in entry.vessels if name not in VESSEL_GROUPS and not is_file_name(name)]
    kinds = {is_3dof for name in entry.vessels for is_3dof in VESSEL_GROUPS.get(name, ())}
    kinds |= {resolve(name).is_3dof for name in texts}
    windy = any("wind" in text for text in (*entry.disturbance, entry.held_out_disturbance))
    models = [(ship, resolve(ship.text)) for ship in asked if ship.file not in entry.vessels]
    return [ship for ship, model in models if model.is_3dof in kinds and (model.windage or not windy)]


@lru_cache(maxsize=8)
def _group(name: str) -> tuple[str, ...]:
    return tuple(vessel for vessel in list_vessels() if resolve(vessel).is_3dof in VESSEL_GROUPS[name])


def _check_vessels(suite: Suite, selection: RunSelection) -> None:
    known = {ship.id for entry in suite.entries for ship in _entry_ships(entry, suite.folder)}
    for vessel in selection.vessels:
        if vessel not in known and not is_file_name(vessel):
            hint = suggestion(vessel, known, f"it has {', '.join(sorted(known))}, or the path of a file of your own")
            raise BadInput(f"suite {suite.name} has no vessel {vessel!r}", hint=hint)
