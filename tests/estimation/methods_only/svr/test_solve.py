"""LS-SVR: primal, dual, kernels, weights."""

import numpy as np
import pytest
from sklearn.linear_model import LinearRegression

from helmbench.estimation.methods_only import svr
from helmbench.estimation.methods_only.svr import LSSVR


def by_dual(x, y, c, weights):
    """The KKT system of eq 25 solved directly."""
    n = len(y)
    system = np.ones((n + 1, n + 1))
    system[0, 0] = 0.0
    system[1:, 1:] = x @ x.T + np.diag(1.0 / (c * weights))
    found = np.linalg.solve(system, np.append(0.0, y))
    return x.T @ found[1:], found[0], found[1:]


def test_primal_is_the_dual(rng):
    """Random sizes, weights and C: equal to 1e-10."""
    for _ in range(200):
        n, d = int(rng.integers(2, 60)), int(rng.integers(1, 8))
        c, weighted = 10.0 ** rng.uniform(-3, 3), rng.random() < 0.7
        x, y = rng.normal(size=(n, d)), rng.normal(size=n)
        weights = rng.uniform(0.1, 2.0, n) if weighted else np.ones(n)
        coef, intercept, alpha = by_dual(x, y, c, weights)
        found_coef, level = svr.primal(x, y, c, weights if weighted else None)
        scale = 1e-10 * max(1.0, np.abs(coef).max(), abs(intercept))
        assert np.abs(found_coef - coef).max() < scale and abs(level - intercept) < scale
        if not weighted:
            fitted = LSSVR(C=c).fit(x, y)
            assert np.array_equal(fitted.coef_, found_coef)
            assert np.abs(fitted.dual_coef_ - alpha).max() < 1e-8 * c * max(1.0, np.abs(y).max())


def test_dual_by_cholesky_is_the_kkt_system(rng):
    for _ in range(50):
        n, c = int(rng.integers(2, 50)), 10.0 ** rng.uniform(-2, 2)
        x, y, weights = rng.normal(size=(n, 3)), rng.normal(size=n), rng.uniform(0.2, 2.0, n)
        _, intercept, alpha = by_dual(x, y, c, weights)
        found_alpha, level = svr.dual(svr.kernel_matrix("linear", x, x, 1.0), y, c, weights)
        assert np.abs(found_alpha - alpha).max() < 1e-10 * max(1.0, np.abs(alpha).max())
        assert abs(level - intercept) < 1e-10 * max(1.0, np.abs(alpha).max())


def test_a_huge_c_keeps_the_digits(rng):
    """At C = 1e10 the primal is least squares to rounding."""
    x = rng.normal(size=(300, 4))
    truth = rng.normal(size=4)
    y = x @ truth + 0.7
    coef, level = svr.primal(x, y, 1e14)
    assert np.abs(coef - truth).max() < 1e-13 * 10 and abs(level - 0.7) < 1e-12
    noisy = y + rng.normal(size=300)
    least = LinearRegression().fit(x, noisy)
    assert svr.primal(x, noisy, 1e10)[0] == pytest.approx(least.coef_, rel=1e-9, abs=1e-11)


def close(values, expected):
    """As `pytest.approx` with rel=1e-11 and abs=1e-12, which takes seconds for so many elements."""
    return np.all(np.abs(values - expected) <= np.maximum(1e-11 * np.abs(expected), 1e-12))


@pytest.mark.parametrize("kind", ["linear", "rbf"])
def test_kernel_values(kind, rng):
    a, b = rng.normal(size=(600, 3)), rng.normal(size=(40, 3))
    expected = {
        "linear": a @ b.T,
        "rbf": np.exp(-0.3 * ((a[:, None] - b) ** 2).sum(axis=2)),
    }[kind]
    assert close(svr.kernel_matrix(kind, a, b, 0.3), expected)
    whole, upper = (
        svr.kernel_matrix(kind, a, a, 0.3),
        svr.kernel_matrix(kind, a, a, 0.3, upper=True),
    )
    assert close(np.triu(upper), np.triu(whole))


def test_mad_rule_and_pseudo_median():
    values = np.array([1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0, 100.0])
    assert svr.within_mad(values).tolist() == [True] * 7 + [False]
    assert svr.pseudo_median(values) == pytest.approx((3.5 + 5.5) / 2.0)
    assert svr.adaptive_weights(np.zeros(4)).tolist() == [1.0] * 4
    weights = svr.adaptive_weights(np.array([-1.0, 1.0, 3.0, -3.0]))
    assert weights[0] == weights[1] > weights[2] == weights[3]
