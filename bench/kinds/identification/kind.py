"""The kind `identification`."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from typing import TYPE_CHECKING, Any

from ....models.errors import BadInput
from ..base import Kind, RunSelection, Suite, Tables
from .columns import KEYS, PARAMETER_COLUMNS, PARAMETERS, RESULTS, result_columns
from .content import content
from .execute import execute
from .plan import RunSpec, plan
from .problems import HELD_OUT_SEED, measured_records

if TYPE_CHECKING:
    from ....models.yaml_file import FileContent


class IdentificationKind(Kind):
    """Models are identified from simulated or measured records; parameters and predictions are scored."""

    name = "identification"
    failure_columns = ("method", "variant", "vessel", "model", "train", "noise", "disturbance", "seed")

    @property
    def tables(self) -> Tables:
        return Tables(tuple(KEYS), RESULTS, result_columns(), PARAMETERS, PARAMETER_COLUMNS, ("parameter",))

    def suite_models(self) -> tuple[type[FileContent], type[FileContent]]:
        from .suite import RunsEntry, RunsHead

        return RunsHead, RunsEntry

    def with_seed(self, suite: Suite, selection: RunSelection) -> RunSelection:
        if selection.seed is not None:
            raise BadInput("--seed is for suites that draw their cases", hint=f"suite {suite.name} has fixed seeds")
        return selection

    def plan(self, suite: Suite, selection: RunSelection) -> Sequence[RunSpec]:
        return plan(suite, selection)

    def facts(self, specs: Sequence[RunSpec]) -> Mapping[str, Any]:
        last = max(spec.task.seed for spec in specs)
        return {"seeds": f"0-{last}" if last else "0", "held_out_seed": HELD_OUT_SEED}

    def execute(self, spec: RunSpec) -> dict[str, Any]:
        return execute(spec)

    def content(self, spec: RunSpec) -> str | None:
        return content(spec)

    def describe(self, row: Mapping[str, Any]) -> str:
        variant = "" if row["variant"] == "corrected" else f" ({row['variant']})"
        return f"{row['method']}{variant} on {row['vessel']} as {row['model']}, noise {row['noise']}: {row['error']}"

    def check(self, specs: Iterable[RunSpec]) -> None:
        """Raise `BadInput` where a measured record that the runs need is missing or cannot be read."""
        for task in dict.fromkeys(spec.task for spec in specs if spec.task.measured):
            measured_records(task, task.train, task.vessel)
            measured_records(task, task.held_out, task.held_out_dataset or task.vessel)


KIND = IdentificationKind()
