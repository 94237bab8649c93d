"""Estimated parameters against the true ones: the rows of `parameters.parquet`."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from ....estimation.estimates.estimate import Estimate
    from ....models.model import Model
    from .problems import Truth


def parameter_rows(model: Model, truth: Truth, estimate: Estimate) -> list[dict[str, Any]]:
    """Rows of `parameters.parquet`, without their keys, in the model's order; none of a black box."""
    rows = []
    if not estimate.parameters:
        return rows
    for name, unit in zip(model.parameter_names, model.parameter_units, strict=True):
        true, value = truth.values.get(name), estimate.parameters[name]
        rows.append(
            {
                "parameter": name,
                "unit": unit,
                "true": true,
                "true_kind": None if true is None else truth.kind,
                "estimate": value,
                "stderr": estimate.stderr.get(name),
                "rel_error": abs(value - true) / abs(true) if true else None,
                "crb_sd": truth.crb_sd.get(name),
                "identifiable": truth.identifiable.get(name),
            }
        )
    return rows
