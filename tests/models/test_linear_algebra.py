"""Inverses of information matrices: in units of their diagonal, and of parameters that change nothing."""

import numpy as np
import pytest

from helmbench.models.linear_algebra import finite, information_inverse


def test_the_inverse_does_not_depend_on_the_units_of_the_parameters(rng):
    rows = rng.standard_normal((20, 4))
    units = 10.0 ** rng.uniform(-40.0, 40.0, 4)
    matrix = (rows * units).T @ (rows * units)
    wanted = np.linalg.inv(rows.T @ rows)
    assert information_inverse(matrix, 1e-12) * np.outer(units, units) == pytest.approx(wanted, rel=1e-8)


def test_a_parameter_that_changes_nothing_has_no_covariance(rng):
    rows = rng.standard_normal((20, 3))
    rows[:, 1] = 0.0
    found = information_inverse(rows.T @ rows, 1e-12)
    kept = [0, 2]
    assert not found[1].any() and not found[:, 1].any()
    assert found[np.ix_(kept, kept)] == pytest.approx(np.linalg.inv(rows[:, kept].T @ rows[:, kept]))


def test_what_is_not_finite_is_refused():
    for matrix in (np.array([[np.nan]]), np.array([[np.inf, 0.0], [0.0, 1.0]])):
        with pytest.raises(np.linalg.LinAlgError):
            finite(matrix)
