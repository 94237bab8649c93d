"""Triangular factors against NumPy's least squares."""

import numpy as np
import pytest

from helmbench.estimation.numerics import factors


def test_blocks_make_no_difference(rng, monkeypatch):
    rows = rng.normal(size=(1000, 6)) * [1, 1e3, 1e-3, 1, 1, 1]
    whole = factors.solve(factors.fold(factors.empty(5), rows))
    monkeypatch.setattr(factors, "BLOCK", 64)
    pieces = factors.solve(factors.fold(factors.empty(5), rows))
    expected, residual, *_ = np.linalg.lstsq(rows[:, :5], rows[:, 5], rcond=None)
    assert whole.x == pytest.approx(expected, rel=1e-9)
    assert pieces.x == pytest.approx(expected, rel=1e-9)
    assert whole.residual == pytest.approx(residual[0], rel=1e-9)
    assert whole.covariance == pytest.approx(np.linalg.inv(rows[:, :5].T @ rows[:, :5]), rel=1e-6, abs=1e-15)


def test_ill_conditioned_columns_keep_their_digits(rng):
    """Condition 1e9, which normal equations would square."""
    a = rng.normal(size=(200, 4))
    a[:, 3] = a[:, 0] + 1e-9 * a[:, 3]
    truth = np.array([1.0, 2.0, 3.0, 4.0])
    found = factors.solve(factors.fold(factors.empty(4), np.column_stack([a, a @ truth])))
    assert found.rank == 4 and found.condition > 1e8
    assert found.x == pytest.approx(truth, rel=1e-5)


def test_undetermined_directions(rng):
    a = rng.normal(size=(50, 3))
    a = np.column_stack([a, a[:, 0] + a[:, 1]])
    found = factors.solve(factors.fold(factors.empty(4), np.column_stack([a, a @ [1.0, 2.0, 3.0, 0.0]])))
    assert found.rank == 3 and found.null.shape == (4, 1)
    assert np.abs(a @ found.null).max() < 1e-12
    assert np.isinf(np.diag(found.covariance)).tolist() == [True, True, False, True]
    assert a @ found.x == pytest.approx(a @ [1.0, 2.0, 3.0, 0.0])
    assert found.x[2] == pytest.approx(3.0)
