"""How well the spread of free runs, drawn from the estimate's own uncertainty, tells their errors."""

from __future__ import annotations

from ...estimation.judgement.ensemble import ensemble_scores
from .base import Outcome, score

SEED = 0
"""Of the draws: the same for every run, so that equal estimates have equal scores."""


@score({"crps_free": "float", "coverage_free": "float"}, rank=2)
def spread(outcome: Outcome) -> dict[str, float]:
    """CRPS of an ensemble of free runs over the record's spread, and the share of samples inside its 95 % interval.

    Empty for estimates that state no uncertainty (`estimation.judgement.ensemble`).
    """
    found = ensemble_scores(outcome.estimate, outcome.problem.held_out, SEED)
    return {f"{name}_free": value for name, value in found.items()}
