"""Total least squares against closed forms."""

import numpy as np
import pytest

from helmbench.methods.tls import total

from ..made_up.least_squares import factor_of, problem


def test_tls_is_the_singular_vector(rng):
    a, x = problem(rng, m=3)
    noise = np.abs(np.logspace(-3, 3, 3)) * 0.1
    b = a @ x + 0.1 * rng.normal(size=300)
    a = a + noise * rng.normal(size=a.shape)
    sd = np.append(noise, 0.1)
    vector = np.linalg.svd(np.column_stack([a, b]) / sd)[2][-1] / sd
    assert total(factor_of(a, b), 300, sd)[0] == pytest.approx(-vector[:-1] / vector[-1], rel=1e-8)


def test_tls_removes_the_bias_and_states_its_error(rng):
    """20 % noise on two columns, one exact: least squares is 4 % low, total least squares is not."""
    x, found, plain, stated = np.array([1.0, -2.0, 0.5]), [], [], []
    base = rng.normal(size=(2000, 3))
    for _ in range(120):
        noisy = base + rng.normal(size=base.shape) * [0.2, 0.0, 0.2]
        b = base @ x + 0.2 * rng.normal(size=2000)
        estimate, covariance, _ = total(factor_of(noisy, b), 2000, np.array([0.2, 0.0, 0.2, 0.2]))
        found.append(estimate)
        stated.append(np.sqrt(np.diag(covariance)))
        plain.append(np.linalg.lstsq(noisy, b, rcond=None)[0])
    assert np.mean(found, axis=0) == pytest.approx(x, abs=0.01)
    assert np.mean(plain, axis=0)[0] == pytest.approx(1.0 / 1.04, abs=0.01)
    assert np.all(np.abs(np.log(np.std(found, axis=0) / np.mean(stated, axis=0))) < 0.3)  # scatters by .065


def test_tls_of_exact_columns_is_least_squares(rng):
    a, x = problem(rng)
    b = a @ x + rng.normal(size=300)
    found, covariance, _ = total(factor_of(a, b), 300, np.array([0.0, 0.0, 0.0, 0.0, 1.0]))
    assert found == pytest.approx(np.linalg.lstsq(a, b, rcond=None)[0], rel=1e-9)
    expected = np.linalg.inv(a.T @ a) * np.sum((b - a @ found) ** 2) / 296
    assert np.diag(covariance) == pytest.approx(np.diag(expected), rel=1e-6)
