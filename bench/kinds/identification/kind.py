"""The kind `identification`: models are identified from records; parameters and predictions are scored."""

from __future__ import annotations

import hashlib
from collections.abc import Iterable, Mapping, Sequence
from typing import Any

from ....models.errors import BadInput
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


def content(spec: RunSpec) -> str | None:
    """Digest of a run's method and task, whatever the suite is called; None for a method of a file: it may change."""
    return None if ".py:" in spec.maker else hashlib.sha256(spec.text(suite="").encode()).hexdigest()[:20]


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
