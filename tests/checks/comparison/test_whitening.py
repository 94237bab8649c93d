"""Whitening of white noise on a random walk."""

import numpy as np
import pytest

from helmbench.checks.comparison.blocks import Rows, fit, p_value, sums_of, whitened_steps


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
            rows = Rows(size * x + noise, x[:, None], np.zeros((n, 0)))
            found = fit([sums_of(rows, np.linspace(0.0, 1.0, n))], [0])
            if size:
                inside += abs(found.values[0] - size) < 1.796 * np.sqrt(found.covariance[0, 0])
            else:
                alarms += p_value(found, [0]) < 1e-4
    assert inside >= 44 and alarms <= 1
