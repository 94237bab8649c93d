"""The kind `identification`: models are identified from records; parameters and predictions are scored."""

from __future__ import annotations

import hashlib
from collections.abc import Iterable, Mapping, Sequence
from functools import lru_cache
from pathlib import Path
from typing import Any

from ....methods.registry import FAMILIES, find
from ....models.errors import BadInput
from ...content import PACKAGE, ROOT, sources_digest
from ..base import Kind, RunSelection, Suite, Tables
from .columns import KEYS, PARAMETER_COLUMNS, PARAMETERS, RESULTS, result_columns
from .execute import execute
from .plan import RunSpec, plan
from .problems import HELD_OUT_SEED, measured_records


def without_seed(suite: Suite, selection: RunSelection) -> RunSelection:
    if selection.seed is not None:
        raise BadInput("--seed is for suites that draw their cases", hint=f"suite {suite.name} has fixed seeds")
    return selection


def facts(specs: Sequence[RunSpec]) -> Mapping[str, Any]:
    last = max(spec.task.seed for spec in specs)
    return {"seeds": f"0-{last}" if last else "0", "held_out_seed": HELD_OUT_SEED}


def describe(row: Mapping[str, Any]) -> str:
    variant = "" if row["variant"] == "corrected" else f" ({row['variant']})"
    return f"{row['method']}{variant} on {row['vessel']} as {row['model']}, noise {row['noise']}: {row['error']}"


def check(specs: Iterable[RunSpec]) -> None:
    """Raise `BadInput` where a measured record that the runs need is missing or cannot be read."""
    for task in dict.fromkeys(spec.task for spec in specs if spec.task.measured):
        measured_records(task, task.train, task.vessel)
        measured_records(task, task.held_out, task.held_out_dataset or task.vessel)


# ---- What the result of an identification run depends on: its task, its method's sources and those that score it.

RUN = (Path(__file__).parent, ROOT / "bench" / "scores")
"""Folders all of whose files make the row of a run."""


def content(spec: RunSpec) -> str | None:
    """Digest of a run's task, options, sources and versions; None where its method's sources are not all known."""
    sources = _sources(spec.maker.partition(",")[0])
    if sources is None:
        return None
    return hashlib.sha256(f"{spec.text(suite='')}{sources}".encode()).hexdigest()[:20]


@lru_cache(maxsize=256)
def _sources(method: str) -> str | None:
    """Digest of the sources of a method, named as in `methods.registry.find`."""
    paths = [path.relative_to(ROOT).with_suffix("") for folder in RUN for path in folder.glob("*.py")]
    own = [".".join([PACKAGE, *path.parts]) for path in paths]
    return sources_digest(*sorted({*own, *_modules(method)}))


def _modules(method: str) -> list[str]:
    """Modules and files that define a method's class, its base classes, and the method or package that it wraps."""
    prefix, colon, rest = method.partition(":")
    if colon and prefix in FAMILIES:
        wrapped = _modules(rest) if prefix == "tuned" else [rest.partition(".")[0] if "." in rest else prefix]
        return [f"{PACKAGE}.methods.{FAMILIES[prefix][0]}", *wrapped]
    if ".py:" in method:
        return [method.rpartition(":")[0]]
    return [cls.__module__ for cls in find(method).__mro__ if cls.__module__ not in ("builtins", "abc")]


KIND = Kind(
    name="identification",
    failure_columns=("method", "variant", "vessel", "model", "train", "noise", "disturbance", "seed"),
    stored=lambda: Tables(tuple(KEYS), RESULTS, result_columns(), PARAMETERS, PARAMETER_COLUMNS, ("parameter",)),
    with_seed=without_seed,
    plan=plan,
    facts=facts,
    execute=execute,
    content=content,
    describe=describe,
    check=check,
)
