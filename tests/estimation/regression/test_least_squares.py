"""Feasible generalised least squares over several equations."""

import numpy as np
import pytest

from helmbench.estimation.numerics import factors
from helmbench.estimation.regression.least_squares import least_squares
from helmbench.models.errors import FitFailed


def test_each_equation_weighs_by_its_own_noise(rng):
    """Two equations for one unknown, one of them a thousand times noisier and ten thousand times larger."""
    n, truth = 4000, 3.0
    left, right = rng.normal(size=n), 1e4 * rng.normal(size=n)
    small, large = truth * left + 0.01 * rng.normal(size=n), truth * right + 1e6 * rng.normal(size=n)
    equations = [factors.fold(factors.empty(1), np.column_stack(pair)) for pair in ((left, small), (right, large))]
    found = least_squares(np.array(equations), np.array([n, n]))
    assert abs(found.coefficients[0] - truth) < 6.0 * 0.01 / np.sqrt(n)
    assert found.residual_sd == pytest.approx([0.01, 1e6], rel=0.1)
    assert np.sqrt(found.covariance[0, 0]) == pytest.approx(0.01 / np.sqrt(n), rel=0.1)


def test_significant_keeps_what_stands_out(rng):
    n = 500
    strong, weak = rng.normal(size=n), rng.normal(size=n)
    y = 2.0 * strong + 1e-4 * weak + 0.1 * rng.normal(size=n)
    rows = factors.fold(factors.empty(2), np.column_stack([strong, weak, y]))
    found = least_squares(rows[None], np.array([n]))
    assert found.half @ found.scores == pytest.approx(found.coefficients)
    assert found.significant(0.0) == pytest.approx(found.coefficients)
    assert abs(found.significant(1e9)).max() == 0.0
    assert abs(found.significant()[0] - 2.0) < 0.1


def test_nothing_to_regress_on():
    with pytest.raises(FitFailed, match="columns"):
        least_squares(np.zeros((1, 3, 3)), np.array([100]))
