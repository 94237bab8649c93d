"""How well the stated standard errors tell the errors: continuous ranked probability score, and coverage."""

from __future__ import annotations

import numpy as np

from ...estimation.estimates.assessment import NORMAL_95
from .base import Outcome, score


@score({"crps_median": "float", "coverage_95": "float"}, rank=1)
def probability(outcome: Outcome) -> dict[str, float]:
    """Median over the identifiable parameters of CRPS / |true|, and the share of 95 % intervals that hold the true one.

    The estimate and its standard error count as a normal density, whose CRPS has a closed form (Gneiting & Raftery
    2007, Journal of the American Statistical Association 102, eq 21).  With a standard error of zero it is the relative
    error.
    """
    from scipy.stats import norm

    stated = [row for row in outcome.identifiable if row["stderr"] and np.isfinite(row["stderr"])]
    if not stated:
        return {}
    estimate, true, sd = (np.array([row[name] for row in stated], float) for name in ("estimate", "true", "stderr"))
    z = (true - estimate) / sd
    crps = sd * (z * (2.0 * norm.cdf(z) - 1.0) + 2.0 * norm.pdf(z) - 1.0 / np.sqrt(np.pi))
    inside = float(np.mean(np.abs(z) <= NORMAL_95))
    return {"crps_median": float(np.median(crps / np.abs(true))), "coverage_95": inside}
