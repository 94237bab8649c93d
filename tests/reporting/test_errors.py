"""Statistics of free-run errors."""

from dataclasses import replace

import numpy as np
import pytest

from helmbench.reporting.errors import banded, correlation, mean, residual, rms

from ..made_up.diagnosis import made_up


def test_the_spectrum_finds_a_sine_where_it_is(rng):
    time = 0.5 * np.arange(2000)
    error = 0.3 * np.sin(2 * np.pi * 0.1 * time) + 0.01 * rng.normal(size=time.size)
    edges = np.geomspace(0.004, 1.0, 15)
    level = banded(time, error, edges)
    assert edges[np.nanargmax(level)] <= 0.1 <= edges[np.nanargmax(level) + 1]
    assert correlation(time, error, 10.0) > 0.95 and correlation(time, rng.normal(size=2000), 10.0) < 0.15


def test_the_spectrum_holds_the_power_of_the_error(rng):
    time = np.arange(4096.0)
    error = rng.normal(size=time.size)
    level = banded(time, error, np.linspace(0.0, 0.5, 3))
    assert level.sum() * 0.25 == pytest.approx(1.0, rel=0.15)


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
