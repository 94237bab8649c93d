"""Correlations of residuals: the coefficients, and the share that lies inside the bands."""

import numpy as np
import pytest

from helmbench.datasets.generator import Case, generate
from helmbench.estimation.estimates.correlation import Correlation, _channel, channel_residuals, correlation
from helmbench.methods.registry import make
from helmbench.models.model import resolve


def coloured(rng, n, pole):
    """A first-order series of white noise."""
    from scipy.signal import lfilter

    return lfilter([1.0], [1.0, -pole], rng.standard_normal(n + 200))[200:]


def test_coefficients_are_those_of_the_definition(rng):
    pairs = [(rng.standard_normal(n), rng.standard_normal(n)) for n in (40, 60)]
    first, second = zip(*pairs, strict=True)
    found = correlation(first, second, 5)
    power = np.sqrt(sum(a @ a for a in first) * sum(b @ b for b in second))
    for lag in range(6):
        expected = sum(sum(a[i] * b[i - lag] for i in range(lag, a.size)) for a, b in pairs) / power
        assert found[lag] == pytest.approx(expected, abs=1e-12)


@pytest.mark.parametrize("pole", [0.0, 0.9])
def test_independent_series_lie_inside_the_bands(rng, pole):
    """1 % of the coefficients lie outside, also of the cross-correlation of coloured series (Ljung)."""
    found = [_channel("yaw_rate_rad_s", [(coloured(rng, 1500, pole), coloured(rng, 1500, 0.9))], 1.0, 1.0)
             for _ in range(450)]  # fmt: skip
    share = np.mean([one.with_rudder.outside / one.with_rudder.values.size for one in found])
    assert 0.002 < share < 0.025
    alarms = np.mean([one.with_rudder.significant for one in found])
    assert alarms < 0.06
    if pole == 0.0:
        assert 0.004 < np.mean([one.in_time.outside / one.in_time.values.size for one in found]) < 0.017
        assert np.mean([one.in_time.significant for one in found]) < 0.06
    else:
        assert all(one.in_time.significant for one in found)


def test_what_the_rudder_leaves_behind_is_found(rng):
    rudder, noise = coloured(rng, 1500, 0.9), rng.standard_normal(1500)
    late = np.concatenate([np.zeros(15), rudder[:-15]])
    one = _channel("yaw_rate_rad_s", [(noise + 0.5 * late, rudder)], 1.0, 0.5)
    assert one.with_rudder.significant
    assert one.with_rudder.lag_s[int(np.argmax(np.abs(one.with_rudder.values)))] == pytest.approx(7.5, abs=4.0)


def test_the_simultaneous_band_is_wider():
    one = Correlation(np.arange(1.0, 26.0), np.append(np.zeros(24), 0.11), 0.1)
    assert one.outside == 1 and not one.significant
    assert one._replace(values=np.append(np.zeros(24), 0.2)).significant


def test_residuals_of_the_right_model_have_the_size_of_the_noise(seed):
    record = generate(Case("response-1", "zigzag:20/20", "medium", seed=seed))
    gap = record.column("heading_rad").copy()
    gap[100:110] = np.nan
    record = record.with_channels(heading_rad=gap)
    found = channel_residuals(make("output-error").fit(record, resolve("response-1")), [record])
    assert [one.channel for one in found] == ["yaw_rate_rad_s", "heading_rad"]
    assert all(0.8 < one.ratio < 1.25 for one in found)
    assert found[1].n == record.n - 10
