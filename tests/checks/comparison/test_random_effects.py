"""Mean over records: equal sizes, sizes that differ, one record."""

import numpy as np
import pytest

from helmbench.checks.comparison.blocks import random_effects_mean


def test_sizes_of_the_literature():
    """Three zigzags' yaw-rate biases, deg/s: Hartung and Knapp by hand, t(2) = 2.92."""
    values, spread = np.array([0.0312, 0.0394, 0.0304]), np.full(3, 0.0002)
    mean = random_effects_mean(values, spread)
    half = 2.91999 * values.std(ddof=1) / np.sqrt(3.0)
    assert mean.value == pytest.approx(values.mean(), rel=1e-3)
    assert mean.high - mean.value == pytest.approx(half, rel=1e-3)
    assert mean.p_equal < 1e-10 and mean.between == pytest.approx(values.std(ddof=1), rel=1e-2)


def test_equal_sizes_are_told_as_equal(rng):
    """p-values of equal sizes are uniform: of 400, between 5 and 45 below .05 (20 expected)."""
    draws = [random_effects_mean(rng.normal(1.0, 0.1, 5), np.full(5, 0.1)) for _ in range(400)]
    assert 5 <= sum(d.p_equal < 0.05 for d in draws) <= 45
    assert np.mean([d.low <= 1.0 <= d.high for d in draws]) > 0.85


def test_one_record_has_its_own_interval():
    mean = random_effects_mean(np.array([2.0]), np.array([0.5]))
    assert (mean.value, mean.p_equal, mean.between) == (2.0, 1.0, 0.0)
    assert mean.high == pytest.approx(2.0 + 1.6449 * 0.5, abs=1e-3)
