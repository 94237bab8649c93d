"""Errors of predicted held-out records: pooled, record by record, and beside the spread that the estimate states.

Free run: `estimation/run/run.py`, as every command has it.  One step: every sample is predicted from the one before.
Both are compared with the record's own samples and pooled over all held-out records;
heading is unwrapped.  Units are those of the channels.
"""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from ...estimation.judgement.ensemble import ensemble_scores
from ...estimation.records.naming import named
from ...estimation.run.prediction import prediction_scores
from ...estimation.run.run import CHANNELS
from .base import Outcome, score

COLUMNS = [
    f"{name}_{horizon}_{channel}" for horizon in ("free", "one") for name in ("rmse", "r2") for channel in CHANNELS
]


@score(dict.fromkeys(COLUMNS, "float"), rank=2)
def prediction_error(outcome: Outcome) -> dict[str, float]:
    """RMSE and R^2 by horizon and channel."""
    return {name: outcome.prediction[name] for name in COLUMNS if name in outcome.prediction}


# ---- How well the spread of free runs, drawn from the estimate's own uncertainty, tells their errors.

SEED = 0
"""Of the draws: the same for every run, so that equal estimates have equal scores."""


@score({"crps_free": "float", "coverage_free": "float"}, rank=2)
def spread(outcome: Outcome) -> dict[str, float]:
    """CRPS of an ensemble of free runs over the record's spread, and the share of samples inside its 95 % interval.

    Empty for estimates that state no uncertainty (`estimation.judgement.ensemble`).
    """
    found = ensemble_scores(outcome.estimate, outcome.problem.held_out, SEED)
    return {f"{name}_free": value for name, value in found.items()}


# ---- The prediction error of every held-out record by itself.

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
        name: _rounded(mean_nrmse(prediction_scores(estimate.model, [record], estimate.predictor)))
        for name, record in named(outcome.problem.held_out).items()
    }
    return {"nrmse_by_record": json.dumps(found)}


def mean_nrmse(scores: Mapping[str, Any], channels: Sequence[str] = RANKED) -> float:
    """Mean over channels of sqrt(1 - R^2) of free runs (`prediction_scores`); infinite where one diverged."""
    known = np.array([scores[name] for name in (f"r2_free_{channel}" for channel in channels) if name in scores], float)
    known = known[np.isfinite(known)]
    if scores["diverged"] or not known.size:
        return float(np.inf)
    return float(np.mean(np.sqrt(np.maximum(0.0, 1.0 - known))))


def _rounded(error: float) -> float | None:
    return float(f"{error:.4g}") if np.isfinite(error) else None
