"""Statistics of blocks: whitening of white noise on a random walk, and means over records that differ."""

import numpy as np
import pytest

from helmbench.checks.comparison.blocks import fit, p_value, random_effects_mean, sums_of, whitened_steps


def test_noise_becomes_white_with_unit_variance(rng):
    white, walk, n = 0.7, 0.05, 20_000
    series = rng.normal(0.0, white, n) + np.cumsum(rng.normal(0.0, walk, n))
    joined = np.ones(n - 1, bool)
    joined[::997] = False
    out = whitened_steps(series[None], joined, white, np.full(n - 1, walk))[0]
    assert out.size == joined.sum() and out.var() == pytest.approx(1.0, abs=0.05)
    correlations = [np.corrcoef(out[k:], out[:-k])[0, 1] for k in (1, 2, 10)]
    assert np.abs(correlations).max() < 5.0 / np.sqrt(n)


def test_a_break_keeps_its_jump_out(rng):
    series = rng.normal(0.0, 0.1, 500) + np.where(np.arange(500) < 250, 0.0, 100.0)
    joined = np.arange(499) != 249
    out = whitened_steps(series[None], joined, 0.1, np.full(499, 0.01))
    assert np.abs(out).max() < 6.0


def test_blocks_tell_an_effect_and_its_interval(rng):
    """Correlated rows: the 90 % interval covers, and an effect of nothing has no small p-value."""
    n, inside, alarms = 1200, 0, 0
    for _ in range(60):
        noise = np.convolve(rng.normal(size=n + 9), np.ones(10) / 10.0, "valid")
        x = np.sin(np.arange(n) / 15.0)
        for size in (0.3, 0.0):
            rows = np.stack([size * x + noise, x])
            found = fit([sums_of(rows, np.linspace(0.0, 1.0, n))], [0])
            if size:
                inside += abs(found.values[0] - size) < 1.796 * np.sqrt(found.covariance[0, 0])
            else:
                alarms += p_value(found, [0]) < 1e-4
    assert inside >= 44 and alarms <= 1


# ---- Mean over records: equal sizes, sizes that differ, one record.


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
