"""Schemes by name: what they refuse."""

from dataclasses import replace

import numpy as np
import pytest

from helmbench.estimation.regression.schemes import regression_samples
from helmbench.models.errors import CannotFit
from helmbench.models.model import resolve

from ...made_up.records import driven


def smooth_rudder(dt, duration=60.0):
    time = np.arange(0.0, duration, dt)
    return 0.2 * np.sin(0.7 * time) * (1.0 - np.exp(-time)) + 0.1 * np.sin(0.23 * time) ** 2


def test_columns_that_are_missing_are_named():
    model = resolve("kvlcc2-l7")
    record = driven(model, smooth_rudder(0.1), 0.1)
    with pytest.raises(CannotFit, match="driven has no column sway_m_s"):
        regression_samples([record.with_channels(sway_m_s=None)], model, "forward")
    with pytest.raises(CannotFit, match="no column heading_rad"):
        response = resolve("response-1")
        regression_samples([record.with_channels(yaw_rate_rad_s=None, heading_rad=None)], response, "forward")


def test_schemes_that_do_not_suit_the_model():
    model = resolve("response-1")
    record = driven(model, smooth_rudder(0.1), 0.1)
    with pytest.raises(CannotFit, match="second-order"):
        regression_samples([record], model, "heading-difference")
    with pytest.raises(CannotFit, match="no channel"):
        steered = replace(resolve("cargo"), family="nomoto-2-steered", constants=np.array([0.12, 5.0]))
        regression_samples([record], steered, "forward")


def test_too_few_rows():
    model = resolve("kvlcc2-l7")
    record = driven(model, smooth_rudder(0.1), 0.1).slice(0, 7)
    with pytest.raises(CannotFit, match="18 usable regression rows for 20 coefficients"):
        regression_samples([record], model, "forward")
