"""Errors of the identifiable parameters in units of their Cramer-Rao bounds."""

from __future__ import annotations

import numpy as np

from ..kinds.identification.problems import GIVEN
from .base import Outcome, score


@score({"crb_z_rms": "float"}, rank=1)
def efficiency(outcome: Outcome) -> dict[str, float]:
    """Root mean square of (estimate - true) / bound; 1 for an efficient method, over many seeds.

    Only where the fitted family is the truth's: a bound says nothing of a model that leaves something out.
    """
    own = [row for row in outcome.identifiable if row["true_kind"] == GIVEN]
    bounded = [row for row in own if row["crb_sd"] and np.isfinite(row["crb_sd"])]
    z = np.array([(row["estimate"] - row["true"]) / row["crb_sd"] for row in bounded], dtype=float)
    return {"crb_z_rms": float(np.sqrt(np.mean(z**2)))} if z.size else {}
