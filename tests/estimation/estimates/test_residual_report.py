"""Residual statistics: whiteness by Ljung and Box, and what a wrong model leaves."""

import numpy as np
import pytest
from scipy.stats import chi2

from helmbench.datasets.generator import Case, generate
from helmbench.estimation.estimates.correlation import LARGEST_LAG, ljung_box
from helmbench.methods.registry import make
from helmbench.models.errors import BadInput
from helmbench.models.model import resolve


def test_the_statistic_of_a_series_by_hand():
    residuals = np.array([1.0, -1.0, 1.0, -1.0, 1.0, -1.0])
    rho = (residuals[1:] @ residuals[:-1]) / (residuals @ residuals)
    assert ljung_box(residuals) == (pytest.approx(6 * 8 * rho**2 / 5), 1)
    assert ljung_box(np.full(50, 3.0)) == (0.0, 5)


def test_white_noise_is_rejected_at_the_level_of_the_test(rng):
    """Of 2000 white series a share of 0.05 is rejected, to within 4.5 of its standard deviations."""
    draws = [ljung_box(rng.normal(size=500)) for _ in range(2000)]
    assert {lags for _, lags in draws} == {LARGEST_LAG}
    rejected = np.mean([q > chi2.ppf(0.95, lags) for q, lags in draws])
    assert abs(rejected - 0.05) < 4.5 * np.sqrt(0.05 * 0.95 / 2000) + 0.01


def test_the_right_model_leaves_white_residuals_and_a_poor_one_does_not():
    records = [generate(Case("response-1", text, "low", seed=4)) for text in ("zigzag:20/20", "turn:20")]
    right = make("output-error").fit(records, resolve("nomoto-1-cubic")).residual_report(records)
    poor = make("output-error").fit(records, resolve("nomoto-1")).residual_report(records)
    assert list(right.index) == ["heading_rad", "yaw_rate_rad_s"] and list(right["unit"]) == ["rad", "rad/s"]
    assert (right["n"] == sum(record.n for record in records)).all() and (right["degrees"] == 2 * LARGEST_LAG).all()
    assert right.loc["yaw_rate_rad_s", "p_white"] > 1e-4 and abs(right.loc["yaw_rate_rad_s", "lag_1"]) < 0.1
    assert (poor["p_white"] < 1e-12).all() and (poor["lag_1"] > 0.5).all()
    np.testing.assert_allclose(right["rmse"] ** 2, right["mean"] ** 2 + right["sd"] ** 2, rtol=1e-3)


def test_one_step_residuals_and_an_unknown_horizon():
    record = generate(Case("response-1", "zigzag:20/20", "low"))
    estimate = make("output-error").fit(record, resolve("nomoto-1-cubic"))
    report = estimate.residual_report(record, "one")
    assert report.loc["yaw_rate_rad_s", "rmse"] == estimate.score(record)["rmse_one_yaw_rate_rad_s"]
    assert (report["lag_1"] < -0.2).all()  # every prediction starts from a noisy sample
    with pytest.raises(BadInput, match="unknown horizon 'two'"):
        estimate.residual_report(record, "two")
