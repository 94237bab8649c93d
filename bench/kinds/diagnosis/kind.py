"""The kind `diagnosis`: effects are injected in simulated records; what diagnosers say is scored."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from ..base import Kind, Tables
from .columns import CASE_COLUMNS, CASES, KEYS, SIZE_COLUMNS, SIZE_KEYS, SIZES
from .execute import execute
from .plan import plan, with_seed


def describe(row: Mapping[str, Any]) -> str:
    injected = f"{row['injected']} injected ({row['strength']})" if row["injected"] else "nothing injected"
    return f"{row['method']} on {row['vessel']}, {injected}, gusts {row['gusts']}: {row['error']}"


KIND = Kind(
    name="diagnosis",
    failure_columns=tuple(name for name in KEYS if name != "suite"),
    stored=lambda: Tables(tuple(KEYS), CASES, CASE_COLUMNS, SIZES, SIZE_COLUMNS, SIZE_KEYS),
    with_seed=lambda suite, selection: with_seed(selection),
    plan=plan,
    facts=lambda specs: {"cases": len({(spec.group, spec.seed) for spec in specs})},
    execute=execute,
    describe=describe,
)
