"""How far ahead methods can be trusted on measured records, beside two predictions without a model."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from ...bench.scores.errors_ahead import LENGTHS, PREFIXES
from ..numbers import DEG, number
from ..tables import Column, Table, field, make_table

if TYPE_CHECKING:
    from collections.abc import Mapping

    from .standings import Frame

KEYS = ["vessel", "method", "model"]
NOTE = (
    "Medians over runs on measured records. Trust: time ahead up to which heading and yaw rate are predicted better "
    "than by a ship that goes on turning as now and by one that goes straight. Errors of yaw rate ahead, deg/s, as "
    "model / goes on turning / goes straight; times are ship lengths, or times sqrt(T / K) where no length is known."
)


def ahead_table(results: Frame) -> Table:
    """Methods on measured records by how far ahead to trust them; no row where no run was scored ahead."""
    known = results[results["trusted_s"].notna()] if "trusted_s" in results else None
    rows = (
        []
        if known is None
        else [
            dict(zip(KEYS, key, strict=True)) | {name: _median(own, name) for name in own if name.startswith(WANTED)}
            for key, own in known.groupby(KEYS, observed=True)
        ]
    )
    rows.sort(key=lambda row: (row["vessel"], -row["trusted_s"]))
    columns = [
        *map(field, KEYS),
        Column("trust it for, s", lambda row: number(row["trusted_s"]), lambda row: row["trusted_s"]),
        *(Column(f"{length:g} lengths", _errors(length)) for length in LENGTHS),
        Column("sensor noise", lambda row: number(_of(row, "noise_yaw_rate_rad_s"))),
    ]
    return make_table(columns, rows, "How far ahead, measured records", NOTE)


WANTED = ("trusted_s", "noise_", *(f"rmse_{prefix}_" for prefix in PREFIXES.values()))


def _median(own: Frame, name: str) -> float:
    values = own[name].to_numpy(float)
    return float(np.median(values[np.isfinite(values)])) if np.isfinite(values).any() else float("nan")


def _errors(length: float) -> Any:
    names = [f"rmse_{prefix}_{length:g}_yaw_rate_rad_s" for prefix in PREFIXES.values()]

    def text(row: Mapping[str, Any]) -> str:
        values = [_of(row, name) for name in names]
        return " / ".join(map(number, values)) if np.isfinite(values).any() else ""

    return text


def _of(row: Mapping[str, Any], name: str) -> float:
    return DEG * row.get(name, float("nan"))
