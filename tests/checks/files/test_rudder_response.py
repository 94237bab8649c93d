"""The answer of the yaw rate to the rudder."""

import numpy as np
import pytest

from helmbench.checks.files.rudder_response import _fitted, _Grid


def test_the_answer_is_that_of_a_regression_with_a_constant_for_each_record(rng):
    """The constants are taken off all columns: a column for each of many records would cost their cube."""
    grids = [_Grid(*rng.normal(size=(3, 40)) + rng.normal(size=(3, 1)), 1.0) for _ in range(3)]
    columns = [np.concatenate([getattr(g, name) for g in grids]) for name in ("rudder", "rate", "slope")]
    constants = np.kron(np.eye(3), np.ones((40, 1)))
    phi = np.column_stack([columns[0], columns[1], columns[1] * np.abs(columns[1]), constants])
    b = np.linalg.lstsq(phi, columns[2])[0]
    left = columns[2] - phi @ b
    without = columns[2] - phi[:, 1:] @ np.linalg.lstsq(phi[:, 1:], columns[2])[0]
    sd = np.sqrt(np.linalg.inv(phi.T @ phi)[0, 0] * (left @ left) / (120 - 6))
    z, share = _fitted(grids, 0)
    assert z == pytest.approx(b[0] / sd) and share == pytest.approx(1.0 - (left @ left) / (without @ without))
