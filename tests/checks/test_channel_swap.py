"""Two columns under each other's names, with gaps in one of them."""

import numpy as np
import pytest

from helmbench.bench.faults import FaultCase, inject
from helmbench.checks.check import check, examine
from helmbench.datasets.generator import Case, generate
from helmbench.datasets.geometry import velocity_over_ground


def test_an_exchange_leaves_no_samples_out(seed):
    record = generate(Case("mariner", "zigzag:20/20", "low", seed=seed, duration_s=500.0))
    rate = np.where(np.arange(record.n) % 9 == 0, np.nan, record.column("yaw_rate_rad_s"))
    swapped = record.with_channels(heading_rad=rate, yaw_rate_rad_s=record.heading_unwrapped())
    (found,) = (f for f in check([swapped]).findings if f.cause == "channel_swap")
    assert found.channels == ("heading_rad", "yaw_rate_rad_s") and found.corrected and found.blanked == 0


def test_a_yaw_rate_that_is_another_quantity_is_left_out(seed):
    """A roll rate under the name: a roll that follows the turn, and its slope."""
    record = generate(Case("mariner", "zigzag:20/20", "low", seed=seed, duration_s=500.0))
    rate = record.column("yaw_rate_rad_s")
    roll = np.gradient(np.convolve(rate, np.ones(5) / 5.0, mode="same"), record.time_s)
    (found,) = (f for f in check([record.with_channels(yaw_rate_rad_s=roll)]).findings if f.cause == "channel_swap")
    assert found.channels == ("yaw_rate_rad_s",) and "another quantity" in found.evidence
    assert not examine([record.with_channels(yaw_rate_rad_s=roll)]).records[0].has("yaw_rate_rad_s")


def test_a_late_or_biased_yaw_rate_is_one(seed):
    record = generate(Case("mariner", "zigzag:20/20", "low", seed=seed, duration_s=500.0))
    rate = record.column("yaw_rate_rad_s")
    step = round(8.0 / record.dt)
    for other in (rate + 0.02, 0.2 * rate, -rate, np.roll(rate, step)):
        found = check([record.with_channels(yaw_rate_rad_s=other)]).findings
        assert not any("another quantity" in f.evidence for f in found)


def test_a_course_in_the_place_of_the_heading_is_told_and_the_heading_is_that_less_the_drift(rng):
    record = inject(FaultCase("kvlcc2-l7", ()), rng).train[0]
    true = record.heading_unwrapped()
    course = true + np.arctan2(record.column("sway_m_s"), record.column("surge_m_s"))
    done = examine([record.with_channels(heading_rad=course)])
    (found,) = (f for f in done.findings if f.cause == "channel_swap")
    assert found.channels == ("heading_rad",) and "course over ground" in found.evidence
    assert np.nanmax(np.abs(done.records[0].heading_unwrapped() - true)) < 1e-9


def smoothed(heading, step_s, lag_s):
    """A heading behind a damped compass."""
    out = heading.copy()
    for k in range(1, out.size):
        out[k] = out[k - 1] + (1.0 - np.exp(-step_s / lag_s)) * (heading[k] - out[k - 1])
    return out


@pytest.mark.parametrize("vessel", ["kvlcc2-l7", "mariner"])
def test_a_heading_that_a_compass_smooths_is_told_with_its_lag_and_a_late_one_is_none(vessel, rng):
    record = inject(FaultCase(vessel, ()), rng).train[0]
    true, lag_s = record.heading_unwrapped(), 8.0 * record.dt
    done = examine([record.with_channels(heading_rad=smoothed(true, record.dt, lag_s))])
    (found,) = (f for f in done.findings if f.cause == "heading_lag")
    assert found.sizes[0].value == pytest.approx(lag_s, rel=0.15)
    assert np.nanstd(done.records[0].heading_unwrapped() - true) < 0.2 * np.std(smoothed(true, record.dt, lag_s) - true)
    for other in (true, np.interp(record.time_s - lag_s, record.time_s, true)):
        assert not any(f.cause == "heading_lag" for f in examine([record.with_channels(heading_rad=other)]).findings)


def test_an_antenna_at_the_point_of_turning_leaves_the_heading_as_it_is(rng):
    """Its track, too, has the direction of the heading; the yaw rate goes with that."""
    record = inject(FaultCase("kvlcc2-l7", ()), rng).train[0]
    psi, ahead = record.heading_unwrapped(), 2.5
    moved = record.with_channels(
        north_m=record.column("north_m") + ahead * np.cos(psi), east_m=record.column("east_m") + ahead * np.sin(psi)
    )
    assert not any(f.cause == "channel_swap" for f in examine([moved]).findings)


@pytest.mark.parametrize("apparent", [False, True])
def test_a_wind_told_from_the_bow_is_told_and_turned(rng, apparent):
    record = inject(FaultCase("mariner", ()), rng).train[0]
    gusts = np.exp(0.05 * rng.normal(size=record.n))
    true, ship = 8.0 * gusts * np.exp(2.0j), velocity_over_ground(record)
    seen = (true + ship if apparent else true) * np.exp(-1j * record.heading_unwrapped())
    wind = {"wind_speed_m_s": np.abs(seen), "wind_direction_rad": np.angle(seen)}
    done = examine([record.with_channels(**wind)])
    (found,) = (f for f in done.findings if f.cause == "channel_swap")
    assert found.channels == tuple(wind) and ("apparent" in found.evidence) == apparent
    direction = np.nanmedian(np.unwrap(done.records[0].column("wind_direction_rad")))
    assert direction == pytest.approx(2.0, abs=0.05)


def test_a_true_wind_stays_as_it_is(rng):
    record = inject(FaultCase("mariner", ()), rng).train[0]
    wind = {
        "wind_speed_m_s": 8.0 * np.exp(0.2 * rng.normal(size=record.n)),
        "wind_direction_rad": np.full(record.n, 2.0),
    }
    assert not any(f.cause == "channel_swap" for f in examine([record.with_channels(**wind)]).findings)
