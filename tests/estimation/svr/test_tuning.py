"""The choice of C."""

import numpy as np
import pytest

from helmbench.estimation.svr.tuning import grid


def test_grid_takes_the_best_of_25():
    found = grid(lambda c: abs(np.log10(c) - 4.0) if c > 1.0 else np.inf)
    assert found.evaluations == 25 and found.value == pytest.approx(1e4)
