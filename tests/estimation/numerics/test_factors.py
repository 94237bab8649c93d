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


@pytest.mark.parametrize("count", [2, 3, 6, 7])
def test_factors_of_all_others_hold_the_rows_of_all_others(rng, count):
    rows = rng.normal(size=(count, 2, 9, 4))
    each = np.linalg.qr(rows, mode="r")
    for left, found in enumerate(factors.of_all_others(each)):
        others = np.delete(rows, left, axis=0).swapaxes(0, 1).reshape(2, -1, 4)
        assert found.swapaxes(1, 2) @ found == pytest.approx(others.swapaxes(1, 2) @ others, rel=1e-12)


def test_all_others_of_many_factors_take_few_decompositions(rng, monkeypatch):
    """The time would grow with the square of their number."""
    decomposed, qr = [], np.linalg.qr
    each = qr(rng.normal(size=(400, 5, 3)), mode="r")
    monkeypatch.setattr(np.linalg, "qr", lambda a, mode: decomposed.append(a.size) or qr(a, mode=mode))
    factors.of_all_others(each)
    assert sum(decomposed) < 4 * 2 * each.size
