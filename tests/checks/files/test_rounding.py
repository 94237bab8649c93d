"""Values that differ by the rounding of numbers alone: constant, and not stored in steps."""

import numpy as np
import pytest

from helmbench.checks.check import check
from helmbench.checks.integrity.runs import never_changes, resolution
from helmbench.datasets.record import Record


def sailed(rng, speeds, place_follows=True):
    """A craft at 5 m/s that turns by more than a radian, whose log shows `speeds` (N, 2) of surge and sway."""
    time = np.arange(200.0)
    heading = 0.7 * np.sin(0.05 * time)
    slower = 1.0 if place_follows else 1.0 - 0.3 * np.sin(0.05 * time) ** 2
    velocity = 5.0004 * slower * np.exp(1j * heading)
    place = np.concatenate([[0.0], np.cumsum(0.5 * (velocity[1:] + velocity[:-1]))])
    channels = {
        "rudder_rad": 0.2 * np.cos(0.05 * time),
        "heading_rad": heading + 1e-4 * rng.standard_normal(time.size),
        "surge_m_s": speeds[:, 0],
        "sway_m_s": speeds[:, 1],
        "north_m": place.real + 1e-2 * rng.standard_normal(time.size),
        "east_m": place.imag + 1e-2 * rng.standard_normal(time.size),
    }
    return Record(time, channels, "run")


def rounded(rng):
    """Speed and course over ground turned by a heading that is equal: 5.0004 and 0 but for the last digits."""
    last = rng.integers(-1, 2, (200, 2)) * [8.881784197001252e-16, 1.1102230246251565e-16]
    return np.array([5.0004, 0.0]) + last


@pytest.mark.parametrize("follows", [True, False])
def test_a_speed_that_is_constant_within_rounding_is_constant_and_not_coarse(follows, rng):
    findings = {(f.cause, *f.channels): f for f in check([sailed(rng, rounded(rng), follows)]).findings}
    assert not [key for key in findings if key[0] == "coarse_channel"]
    for name in ("surge_m_s", "sway_m_s"):
        finding = findings["constant_channel", name]
        assert finding.material is not follows  # positions that confirm the speed make it a remark
        assert ("heading and positions show the same velocity" in finding.evidence) == follows


def test_rounding_is_measured_by_the_values(rng):
    digits = rng.integers(0, 3, 300)
    assert resolution(5.0 + 8.9e-16 * digits) == 0.0 and never_changes(5.0 + 8.9e-16 * digits)
    assert resolution(6e6 + 1e-9 * digits) == 0.0 and never_changes(6e6 + 1e-9 * digits)
    assert resolution(1e-5 * digits) == pytest.approx(1e-5) and not never_changes(1e-5 * digits)
    again = 0.1 * rng.integers(0, 9, 300) + 1e-16 * digits
    assert resolution(again) == pytest.approx(0.1)
