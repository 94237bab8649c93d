"""The choice of C."""

import numpy as np
import pytest

from helmbench.estimation.methods_only.svr.tuning import colony, grid


def test_grid_takes_the_best_of_25():
    found = grid(lambda c: abs(np.log10(c) - 4.0) if c > 1.0 else np.inf)
    assert found.evaluations == 25 and found.value == pytest.approx(1e4)


def test_the_colony_of_the_paper_finds_the_minimum_between_the_points_of_a_grid():
    """1830 moves (30 sources, 30 cycles of 60), the same every time; a place where the fit fails does not stop it."""

    def error(c):
        return abs(np.log10(c) - 4.321) if c > 1.0 else np.inf

    found = colony(error)
    assert found.evaluations == 1830 and found == colony(error)
    assert np.log10(found.value) == pytest.approx(4.321, abs=0.01) and found.error < grid(error).error
