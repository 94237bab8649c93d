"""Relative errors of the identifiable parameters."""

from __future__ import annotations

import numpy as np

from .base import Outcome, score


@score({"rel_error_median": "float", "rel_error_max": "float"}, rank=0)
def parameter_error(outcome: Outcome) -> dict[str, float]:
    """Median and largest of |estimate - true| / |true|."""
    errors = np.array([row["rel_error"] for row in outcome.identifiable], dtype=float)
    if not errors.size:
        return {}
    return {"rel_error_median": float(np.median(errors)), "rel_error_max": float(np.max(errors))}
