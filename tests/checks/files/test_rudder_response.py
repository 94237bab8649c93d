"""The answer of the yaw rate to the rudder."""

import numpy as np
import pytest

from helmbench.checks.files.rudder_response import Means, fitted


def test_the_answer_is_that_of_a_regression_with_a_constant(rng):
    means = Means(*rng.normal(size=(3, 40)) + rng.normal(size=(3, 1)), 1.0, 0.0)
    phi = np.column_stack([means.rudder, means.rate, means.rate * np.abs(means.rate), np.ones(40)])
    b = np.linalg.lstsq(phi, means.slope)[0]
    left = means.slope - phi @ b
    without = means.slope - phi[:, 1:] @ np.linalg.lstsq(phi[:, 1:], means.slope)[0]
    sd = np.sqrt(np.linalg.inv(phi.T @ phi)[0, 0] * (left @ left) / (40 - 4))
    z, share = fitted(means, 0)
    assert z == pytest.approx(b[0] / sd) and share == pytest.approx(1.0 - (left @ left) / (without @ without))
