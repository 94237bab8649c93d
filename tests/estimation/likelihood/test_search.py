"""The search among starts."""

import numpy as np
import pytest

from helmbench.estimation.likelihood.output_error import fit_output_error
from helmbench.estimation.records.series import series_of
from helmbench.models.errors import FitFailed


def test_a_bad_start_reaches_the_same_minimum(suite):
    """Growing horizons bring a start whose free run diverges to the minimum of the good start."""
    model, records = suite("remus", noise="low")
    series = [series_of(r, model) for r in records]
    with np.errstate(all="ignore"):
        good = fit_output_error(series, model, [model.coefficients])
        bad = fit_output_error(series, model, [model.coefficients * [0.2, -1.0, 2.0, 0.3, 5.0, 0.5]])
    assert bad.minimum.cost == pytest.approx(good.minimum.cost, abs=1e-3)


def test_a_model_that_diverges_from_every_start(suite):
    model, records = suite("response-1")
    series = [series_of(record, model) for record in records]
    with pytest.raises(FitFailed, match="diverges from every start"), np.errstate(all="ignore"):
        fit_output_error(series, model, [np.array([50.0, 1.0, 1.0])])
