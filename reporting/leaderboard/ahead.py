"""How far ahead methods can be trusted on measured records, beside two predictions without a model."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from ...bench.scores.errors_ahead import LENGTHS, PREFIXES
from ..numbers import DEG, number
from ..tables import Column, Table, field, make_table
from .columns import numeric

if TYPE_CHECKING:
    from collections.abc import Mapping

    from .standings import Frame

KEYS = ["vessel", "method", "model"]
NOTE = (
    "Medians over runs on measured records. Trust: time ahead up to which heading and yaw rate are predicted better "
    "than by a ship that goes on turning as now and by one that goes straight. Errors of yaw rate ahead, deg/s, as "
    "model / goes on turning / goes straight; times are ship lengths, or times sqrt(T / K) where no length is known."
)


WANTED = ("trusted_s", "noise_", *(f"rmse_{prefix}_" for prefix in PREFIXES.values()))


def ahead_table(results: Frame) -> Table:
    """Methods on measured records by how far ahead to trust them; no row where no run was scored ahead."""
    rows: list[dict[str, Any]] = []
    if "trusted_s" in results:
        known = results[results["trusted_s"].notna()]
        values = known[[name for name in known if name.startswith(WANTED)]].astype(float).replace(np.inf, np.nan)
        medians = values.groupby([known[key] for key in KEYS], observed=True).median().reset_index()
        rows = medians.sort_values(["vessel", "trusted_s"], ascending=[True, False], kind="stable").to_dict("records")
    columns = [
        *map(field, KEYS),
        numeric("trust it for, s", "trusted_s"),
        *(Column(f"{length:g} lengths", _errors(length)) for length in LENGTHS),
        Column("sensor noise", lambda row: number(_of(row, "noise_yaw_rate_rad_s"))),
    ]
    return make_table(columns, rows, "How far ahead, measured records", NOTE)


def _errors(length: float) -> Any:
    names = [f"rmse_{prefix}_{length:g}_yaw_rate_rad_s" for prefix in PREFIXES.values()]

    def text(row: Mapping[str, Any]) -> str:
        values = [_of(row, name) for name in names]
        return " / ".join(map(number, values)) if np.isfinite(values).any() else ""

    return text


def _of(row: Mapping[str, Any], name: str) -> float:
    return DEG * row.get(name, float("nan"))
