"""Weighted regression rows and the scale of residuals."""

import numpy as np
import pytest

from helmbench.estimation.methods_only.regression.weighted import RegressionRows, mad
from helmbench.estimation.regression.samples import RegressionSamples
from helmbench.models.errors import FitFailed
from helmbench.models.model import resolve


def test_a_regression_of_nothing_is_refused():
    rows = RegressionSamples(np.zeros((20, 2)), np.zeros((20, 1)), np.zeros((20, 1)), np.arange(20.0))
    with pytest.raises(FitFailed, match="non-zero columns"):
        RegressionRows([rows], resolve("response-1").blanked())


def test_mad_of_gaussian_numbers(rng):
    assert mad(rng.normal(0.0, 2.0, (40000, 2))) == pytest.approx([2.0, 2.0], rel=0.05)
