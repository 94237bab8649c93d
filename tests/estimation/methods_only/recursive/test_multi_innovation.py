"""Windows of the last innovations."""

import numpy as np

from helmbench.estimation.methods_only.recursive.multi_innovation import MultiInnovationRule
from helmbench.estimation.methods_only.recursive.recursion import RecursionPrior, RecursionState, RowScales


def test_windows_reach_over_blocks_and_records(rng):
    """All samples at once give the same as the samples in pieces of any size."""
    prior = RecursionPrior(1e10, np.zeros(3), "physical")
    y, phi = rng.normal(size=(60, 1)), rng.normal(size=(60, 1, 3))
    scales = RowScales(np.ones(1), np.ones(3), 60)
    whole = RecursionState(prior, scales, MultiInnovationRule(5)).add(y, phi)
    pieces = RecursionState(prior, scales, MultiInnovationRule(5))
    cuts = [slice(0, 1), slice(1, 3), slice(3, 20), slice(20, 60)]
    assert np.array_equal(np.concatenate([pieces.add(y[c], phi[c]) for c in cuts]), whole)
