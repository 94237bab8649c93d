"""How much worse than the base model an extended model may predict what it was not fitted to, and falls of errors."""

from collections.abc import Mapping

import numpy as np

WORSE = 1.05
"""Ratio of the free-run errors (rms) of left-out records to the base model's, in any channel, from which a cause or a
group of numbers is given up."""


def log_fall(before: Mapping[str, float], after: Mapping[str, float]) -> float:
    """By how much the logarithm of the error falls, in the mean over channels that have a positive error in both; 0
    where there is none."""
    shared = [c for c, error in after.items() if error > 0.0 and before.get(c, 0.0) > 0.0]
    return float(np.mean([np.log(before[c] / after[c]) for c in shared])) if shared else 0.0
