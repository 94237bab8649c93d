"""Scores of one estimate: parameter errors, and one-step and free-run prediction of held-out records.

Free run: the model is simulated from the record's first samples with the measured rudder.  One step: every sample is
predicted from the one before.  Both are compared with the record's own samples and pooled over all held-out records;
heading is unwrapped.  Units are those of the channels.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import TYPE_CHECKING, Any

import numpy as np

if TYPE_CHECKING:
    from ..estimation.estimate import Estimate
    from ..models.model import Model
    from .kinds.identification.problems import Truth


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


def parameter_scores(rows: Iterable[Mapping[str, Any]]) -> dict[str, float]:
    """`rel_error_median`, `rel_error_max` and `crb_z_rms` over identifiable parameters with a non-zero truth."""
    rows = [row for row in rows if row["identifiable"] and row["rel_error"] is not None]
    errors = np.array([row["rel_error"] for row in rows], dtype=float)
    bounded = [row for row in rows if row["crb_sd"] and np.isfinite(row["crb_sd"])]
    z = np.array([(row["estimate"] - row["true"]) / row["crb_sd"] for row in bounded], dtype=float)
    scores = {}
    if errors.size:
        scores |= {"rel_error_median": float(np.median(errors)), "rel_error_max": float(np.max(errors))}
    if z.size:
        scores["crb_z_rms"] = float(np.sqrt(np.mean(z**2)))
    return scores
