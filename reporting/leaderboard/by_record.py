"""Errors of every held-out record of measured ships by themselves."""

from __future__ import annotations

import json
from typing import TYPE_CHECKING, Any

from ..numbers import number
from ..tables import Column, Table, field, make_table

if TYPE_CHECKING:
    from .standings import Frame

TITLE = "Errors by record, measured ships"
NOTE = (
    "Free-run error of every held-out record, mean over channels of sqrt(1 - R2), nothing refitted; a dash where it "
    "diverged. `helmbench run --suite SUITE --vessel SHIP --method METHOD -o DIR` makes a row again."
)


def record_table(results: Frame) -> Table:
    """One row a ship, fitted model, method and selection of records; none where no measured run is scored."""
    columns = [
        *(field(name) for name in ("vessel", "model", "method", "train", "noise")),
        Column("error by record", lambda row: _told(row["nrmse_by_record"]), lambda row: _mean(row["nrmse_by_record"])),
    ]
    known = results[results["nrmse_by_record"].notna()] if "nrmse_by_record" in results else results[:0]
    rows = known.sort_values(["vessel", "model", "noise", "method"]).to_dict("records")
    return make_table(columns, rows, TITLE, NOTE)


def _told(text: Any) -> str:
    return ", ".join(f"{name} {number(error)}" for name, error in json.loads(text).items())


def _mean(text: Any) -> float | None:
    errors = list(json.loads(text).values())
    return None if None in errors else sum(errors) / len(errors)
