"""The prediction error of every held-out record by itself."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from ...estimation.records.naming import named
from ...estimation.run.prediction import prediction_scores
from .base import Outcome, score

RANKED = ("heading_rad", "yaw_rate_rad_s", "surge_m_s", "sway_m_s")
"""Channels whose sqrt(1 - R^2) makes the error, as in the leaderboard."""


@score({"nrmse_by_record": "string"}, rank=4)
def record_errors(outcome: Outcome) -> dict[str, str]:
    """JSON text of record -> mean over channels of sqrt(1 - R^2) in free run, null where it diverged.

    Only of measured records: simulated ones can be made again by their texts.
    """
    if not outcome.problem.measured:
        return {}
    estimate = outcome.estimate
    found = {
        name: _rounded(free_run_error(prediction_scores(estimate.model, [record], estimate.predictor)))
        for name, record in named(outcome.problem.held_out).items()
    }
    return {"nrmse_by_record": json.dumps(found)}


def free_run_error(scores: Mapping[str, Any], channels: Sequence[str] = RANKED) -> float:
    """Mean over channels of sqrt(1 - R^2) of free runs (`prediction_scores`); infinite where one diverged."""
    known = np.array([scores[name] for name in (f"r2_free_{channel}" for channel in channels) if name in scores], float)
    known = known[np.isfinite(known)]
    if scores["diverged"] or not known.size:
        return float(np.inf)
    return float(np.mean(np.sqrt(np.maximum(0.0, 1.0 - known))))


def _rounded(error: float) -> float | None:
    return float(f"{error:.4g}") if np.isfinite(error) else None
