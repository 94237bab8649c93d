"""The compiled recursion against the written one, and long trajectories."""

import numpy as np
import pytest

from helmbench.estimation.methods_only.recursive import _kernels, recursion
from helmbench.methods.rls import MultiInnovationRule, Rls


@pytest.mark.parametrize("variant", ["corrected", "as_printed"])
def test_the_compiled_recursion_is_the_written_one(rng, variant):
    """g = P h/(mu/L + h'P h) and eq 22, literally, in NumPy."""
    n, d, mu, weight = 60, 4, 0.97, 3.0
    h, truth = rng.normal(size=(n, d)), rng.normal(size=d)
    y = h @ truth + 0.01 * rng.normal(size=n)
    theta, p, path = np.zeros(d), 100.0 * np.eye(d), []
    for row, left in zip(h, y, strict=True):
        if variant == "corrected":
            gain = p @ row / (mu / weight + row @ p @ row)
            theta = theta + gain * (left - row @ theta)
            p = (p - np.outer(gain, row @ p)) / mu
        else:
            p = p / mu - np.outer(p @ row, row @ p) / (mu**2 / weight + mu * row @ p @ row)
            theta = theta / mu + weight * (left - row @ theta / mu) * (p @ row)
        path.append(theta)
    start, found = np.zeros(d), np.empty((n, d))
    forget = np.full(n, mu)
    if variant == "corrected":
        factor, diagonal = np.eye(d), np.full(d, 100.0)
        _kernels.recursive_ls(y, h, forget, weight, start, factor, diagonal, found)
        # the kernel forgets before a row and the equations after it: the same but for the first and the last
        again, p_first = _forgetting_first(y, h, mu, weight, d)
        assert found == pytest.approx(again, rel=1e-8, abs=1e-10)
        assert (factor.T * diagonal) @ factor == pytest.approx(p_first, rel=1e-8)
    else:
        rule = recursion.LeastSquaresRule(mu, weight, as_printed=True)
        rule.run(y, h, 1, start, 100.0 * np.eye(d), np.zeros(d), found)
        assert found == pytest.approx(np.array(path), rel=1e-8, abs=1e-10)


def _forgetting_first(y, h, mu, weight, d):
    theta, p, path = np.zeros(d), 100.0 * np.eye(d), []
    for row, left in zip(h, y, strict=True):
        p = p / mu
        gain = p @ row / (1.0 / weight + row @ p @ row)
        theta = theta + gain * (left - row @ theta)
        p = p - np.outer(gain, row @ p)
        path.append(theta)
    return np.array(path), p


def test_long_trajectories_are_thinned(monkeypatch, suite):
    model, records = suite("response-1", noise="low")
    whole = Rls().fit(records, model)
    monkeypatch.setattr(recursion, "LONGEST_PATH", 3 * 500)
    thin = Rls().fit(records, model)
    assert thin.trajectory.shape == (len(thin.trajectory_time_s), 3)
    assert len(thin.trajectory) <= 501
    assert np.array_equal(thin.trajectory[-1], whole.trajectory[-1])
    assert np.array_equal(thin.coefficients, whole.coefficients)


# ---- Windows of the last innovations.


def test_windows_reach_over_blocks_and_records(rng):
    """All samples at once give the same as the samples in pieces of any size."""
    y, h = rng.normal(size=60), rng.normal(size=(60, 3))

    def path(cuts):
        rule, state, found = MultiInnovationRule(5), (np.zeros(3), np.eye(3), np.full(3, 1e10)), np.empty((60, 3))
        for cut in cuts:
            rule.run(y[cut], h[cut], 1, *state, found[cut])
        return found

    assert np.array_equal(path([slice(0, 1), slice(1, 3), slice(3, 20), slice(20, 60)]), path([slice(0, 60)]))
