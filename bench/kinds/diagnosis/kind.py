"""The kind `diagnosis`."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

from ..base import Kind, RunSelection, Suite, Tables
from .columns import CASE_COLUMNS, CASES, KEYS, SIZE_COLUMNS, SIZE_KEYS, SIZES
from .execute import execute
from .plan import CaseSpec, plan, with_seed

if TYPE_CHECKING:
    from ....models.yaml_file import FileContent


class DiagnosisKind(Kind):
    """Effects are injected in simulated records; what diagnosers say is scored."""

    name = "diagnosis"
    failure_columns = tuple(name for name in KEYS if name != "suite")

    @property
    def tables(self) -> Tables:
        return Tables(tuple(KEYS), CASES, CASE_COLUMNS, SIZES, SIZE_COLUMNS, SIZE_KEYS)

    def suite_models(self) -> tuple[type[FileContent], type[FileContent]]:
        from .suite import CasesEntry, CasesHead

        return CasesHead, CasesEntry

    def with_seed(self, suite: Suite, selection: RunSelection) -> RunSelection:
        return with_seed(selection)

    def plan(self, suite: Suite, selection: RunSelection) -> Sequence[CaseSpec]:
        return plan(suite, selection)

    def facts(self, specs: Sequence[CaseSpec]) -> Mapping[str, Any]:
        return {"cases": len({(spec.group, spec.seed) for spec in specs})}

    def execute(self, spec: CaseSpec) -> dict[str, Any]:
        return execute(spec)

    def describe(self, row: Mapping[str, Any]) -> str:
        injected = f"{row['injected']} injected ({row['strength']})" if row["injected"] else "nothing injected"
        return f"{row['method']} on {row['vessel']}, {injected}, gusts {row['gusts']}: {row['error']}"


KIND = DiagnosisKind()
