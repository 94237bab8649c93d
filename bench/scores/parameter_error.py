"""Errors of the identifiable parameters: relative, in units of their Cramer-Rao bounds, and against stated errors."""

from __future__ import annotations

import numpy as np

from ...estimation.estimates.assessment import NORMAL_95
from ..kinds.identification.problems import GIVEN
from .base import Outcome, score


@score({"rel_error_median": "float", "rel_error_max": "float"}, rank=0)
def parameter_error(outcome: Outcome) -> dict[str, float]:
    """Median and largest of |estimate - true| / |true|."""
    errors = np.array([row["rel_error"] for row in outcome.identifiable], dtype=float)
    if not errors.size:
        return {}
    return {"rel_error_median": float(np.median(errors)), "rel_error_max": float(np.max(errors))}


# ---- Errors of the identifiable parameters in units of their Cramer-Rao bounds.


@score({"crb_z_rms": "float"}, rank=1)
def efficiency(outcome: Outcome) -> dict[str, float]:
    """Root mean square of (estimate - true) / bound; 1 for an efficient method, over many seeds.

    Only where the fitted family is the truth's: a bound says nothing of a model that leaves something out.
    """
    own = [row for row in outcome.identifiable if row["true_kind"] == GIVEN]
    bounded = [row for row in own if row["crb_sd"] and np.isfinite(row["crb_sd"])]
    z = np.array([(row["estimate"] - row["true"]) / row["crb_sd"] for row in bounded], dtype=float)
    return {"crb_z_rms": float(np.sqrt(np.mean(z**2)))} if z.size else {}


# ---- How well the stated standard errors tell the errors: continuous ranked probability score, and coverage.


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
