"""Statistics of free-run errors."""

from dataclasses import replace

import numpy as np

from helmbench.reporting.diagnosis.tables import correlation, mean, residual
from helmbench.reporting.runs import rms

from ..made_up.diagnosis import made_up


def test_a_slow_error_is_correlated_with_itself_and_noise_is_not(rng):
    time = 0.5 * np.arange(2000)
    error = 0.3 * np.sin(2 * np.pi * 0.1 * time) + 0.01 * rng.normal(size=time.size)
    assert correlation(time, error, 10.0) > 0.95 and correlation(time, rng.normal(size=2000), 10.0) < 0.15


def test_headings_are_compared_within_half_a_turn():
    trace = made_up("response-1", "rudder_offset", {"rudder_offset": 0.02}).traces[0]
    turned = replace(trace, before={**trace.before, "heading_rad": trace.before["heading_rad"] + 4 * np.pi})
    np.testing.assert_allclose(
        residual(turned, "heading_rad", "before"), residual(trace, "heading_rad", "before"), atol=1e-12
    )


def test_gaps_are_left_out():
    values = np.array([3.0, np.nan, -3.0, np.inf])
    assert rms(values) == 3.0 and mean(values) == 0.0
    assert np.isnan(rms(np.array([np.nan])))
    assert rms(np.zeros(2)) == 0.0 and rms(np.array([1e300, -1e300])) == 1e300
