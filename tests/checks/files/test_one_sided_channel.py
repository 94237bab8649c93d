"""A yaw rate of which one side is lost, and what is none: offsets, scales, delays, noise, turns to one side."""

import numpy as np
import pytest

from helmbench.checks.check import check, examine
from helmbench.datasets.record import Record


def zigzag(rng, seconds=240, noise=5e-4, rudder=0.349):
    """A ship of first order (T = 8 s, K = 0.12 1/s) in a zigzag of 20/20 deg, sampled every second."""
    heading, rate, order, rows = 0.0, 0.0, rudder, []
    for k in range(10 * seconds):
        if k % 10 == 0:
            rows.append((heading, rate, order))
        if abs(heading) > np.deg2rad(20.0) and heading * order > 0.0:
            order = -order
        rate += 0.1 * (0.12 * order - rate) / 8.0
        heading += 0.1 * rate
    heading, rate, order = np.array(rows).T
    heading = heading + 2e-3 * rng.standard_normal(heading.size)
    rate = rate + noise * rng.standard_normal(rate.size)
    return Record(
        np.arange(float(seconds)), {"rudder_rad": order, "heading_rad": heading, "yaw_rate_rad_s": rate}, "run"
    )


def found(record, of_rate):
    changed = record.with_channels(yaw_rate_rad_s=of_rate(record.column("yaw_rate_rad_s")))
    return [f for f in check([changed]).findings if f.cause == "one_sided_channel"]


LOST = {
    "nearly lost to port": (lambda r: np.where(r < 0.0, 1e-3 * r, r), 1.0, 0.001),
    "cut off to port": (lambda r: np.maximum(r, 0.0), 1.0, 0.0),
    "cut off to starboard": (lambda r: np.minimum(r, 0.0), 0.0, 1.0),
    "a third to starboard": (lambda r: np.where(r > 0.0, r / 3.0, r), 0.333, 1.0),
    "without its sign": (np.abs, 1.0, -1.0),
}


@pytest.mark.parametrize("name", LOST)
def test_a_side_that_is_lost_is_told_with_both_scales_and_leaves_the_channel_out(name, rng):
    of_rate, starboard, port = LOST[name]
    record = zigzag(rng)
    (finding,) = found(record, of_rate)
    sizes = {s.parameter: s.value for s in finding.sizes}
    assert sizes == pytest.approx({"starboard": starboard, "port": port}, abs=0.03)
    assert finding.material and finding.channels == ("yaw_rate_rad_s",) and finding.blanked == record.n
    assert "turns to starboard" in finding.evidence and "turns to port" in finding.evidence
    assert ("its sign is lost" in finding.evidence) == (name == "without its sign")
    changed = record.with_channels(yaw_rate_rad_s=of_rate(record.column("yaw_rate_rad_s")))
    assert not examine([changed]).records[0].has("yaw_rate_rad_s")


RIGHT = {
    "as it is": lambda r: r,
    "with an offset": lambda r: r + 0.6 * np.max(r),
    "of half the scale": lambda r: 0.5 * r,
    "three seconds late": lambda r: np.roll(r, 3),
    "cut off at half its range": lambda r: np.clip(r, -0.5 * np.max(r), 0.5 * np.max(r)),
    "a fifth weaker to port": lambda r: np.where(r < 0.0, 0.8 * r, r),
    "in degrees": np.rad2deg,
    "of the other sign": lambda r: -r,
    "dead": lambda r: 0.0 * r,
}


@pytest.mark.parametrize("name", RIGHT)
def test_what_concerns_both_sides_is_not_one_sided(name, rng):
    assert not found(zigzag(rng), RIGHT[name])


def test_noise_alone_and_turns_to_one_side_say_nothing(rng):
    still = zigzag(rng, rudder=0.0)
    assert not found(still, np.abs)
    record = zigzag(rng)
    turning = record.with_channels(heading_rad=0.03 * record.time_s + 1e-3 * rng.standard_normal(record.n))
    assert not found(turning, lambda r: 0.03 + 1e-3 * rng.standard_normal(r.size))
    noisy = zigzag(rng, noise=np.deg2rad(8.0))
    assert not found(noisy, lambda r: r)


def test_a_few_seconds_of_turning_to_a_side_are_too_few(rng):
    record = zigzag(rng)
    rate = np.where(record.time_s < 8.0, -0.02, 0.02)
    heading = np.cumsum(rate) + 1e-3 * rng.standard_normal(record.n)
    assert not found(record.with_channels(heading_rad=heading, yaw_rate_rad_s=np.maximum(rate, 0.0)), lambda r: r)
