"""Positions and heading without velocities: a compass that is backwards, and currents that must not look like it."""

import numpy as np
import pytest

from helmbench.bench.faults import FaultCase, inject
from helmbench.checks.check import check, examine
from helmbench.checks.columns import HeadingZero
from helmbench.datasets.record import Record

from ..nightly_marks import nightly_but

SPEED = 5.0


def sailed(rng, offset=0.0, current=0.0, amplitude=0.6, course=0.5):
    """A craft that turns to both sides with a little drift, positions within 0.3 m; `current` north + i east, m/s, and
    a heading that is recorded `offset` rad too large."""
    time = np.arange(300.0)
    heading = course + amplitude * np.sin(0.06 * time)
    rate = amplitude * 0.06 * np.cos(0.06 * time)
    velocity = (SPEED - 5.0j * rate) * np.exp(1j * heading) + current
    place = np.concatenate([[0.0], np.cumsum(0.5 * (velocity[1:] + velocity[:-1]))])
    noise = rng.standard_normal((4, time.size))
    channels = {
        "rudder_rad": 0.3 * np.sin(0.06 * time + 0.8),
        "heading_rad": np.mod(heading + offset + 2e-3 * noise[0], 2.0 * np.pi),
        "yaw_rate_rad_s": rate + 1e-3 * noise[1],
        "north_m": place.real + 0.3 * noise[2],
        "east_m": place.imag + 0.3 * noise[3],
    }
    return Record(time, channels, "run")


def found(record):
    return [f for f in check([record]).findings if f.material]


@pytest.mark.parametrize(("offset", "reading"), [(180.0, "astern"), (90.0, "sideways"), (-120.0, "sideways")])
@pytest.mark.parametrize("current", [0.0, 1.0j])
def test_a_heading_far_off_the_course_is_told_with_its_size_and_the_other_reading(offset, reading, current, rng):
    record = sailed(rng, np.deg2rad(offset), current)
    (finding,) = found(record)
    assert finding.cause == "heading_zero" and finding.corrected and reading in finding.evidence
    (size,) = finding.sizes
    off = np.angle(np.exp(1j * (size.value - np.deg2rad(offset))))
    assert size.parameter == "offset" and abs(off) < (0.05 if current == 0.0 else 0.3)
    left = examine([record]).records[0].heading_unwrapped() - sailed(rng, 0.0, current).heading_unwrapped()
    assert np.abs(np.angle(np.exp(1j * left))).max() < 0.35


def test_a_craft_that_goes_ahead_is_not_turned(rng):
    for offset in (0.0, 0.3, -0.5):
        assert not found(sailed(rng, offset))


@pytest.mark.parametrize("speed", [0.5, 0.9, 1.2, 1.5, 3.0])
@pytest.mark.parametrize("towards_deg", nightly_but(range(0, 360, 30), 0, 90, 210))
@pytest.mark.parametrize("amplitude", [0.05, 0.2, 0.6])
def test_no_current_looks_like_a_turned_heading(speed, towards_deg, amplitude, rng):
    record = sailed(rng, 0.0, speed * SPEED * np.exp(1j * np.deg2rad(towards_deg)), amplitude)
    assert not [f for f in found(record) if f.cause == "heading_zero"]


def test_a_straight_run_says_nothing(rng):
    assert not found(sailed(rng, np.pi, amplitude=0.0).with_channels(yaw_rate_rad_s=None))


def test_a_log_that_says_astern_is_believed(rng):
    record = sailed(rng, np.pi)
    astern = record.with_channels(surge_m_s=np.full(record.n, -SPEED) + 0.01 * rng.standard_normal(record.n))
    assert not [f for f in found(astern) if f.cause == "heading_zero"]


def test_time_that_runs_backwards_is_told_by_positions_alone(rng):
    record = sailed(rng)
    back = record.with_channels(**{n: record.column(n)[::-1].copy() for n in record.channels})
    (finding,) = (f for f in found(back) if f.cause == "channel_sign")
    assert finding.standing and "time runs backwards" in finding.evidence
    assert "heading_zero" not in {f.cause for f in found(back)}
    (finding,) = (f for f in found(back.with_channels(yaw_rate_rad_s=None)) if f.cause == "heading_zero")
    assert "or time runs backwards" in finding.evidence


@pytest.mark.parametrize("offset", [90.0, 180.0])
def test_with_velocities_the_turn_of_the_heading_is_told_and_is_an_instrument(offset, rng):
    case = inject(FaultCase("kvlcc2-l7"), rng)
    wrong = case.train[0].with_channels(heading_rad=case.train[0].heading_unwrapped() + np.deg2rad(offset))
    (fault,) = HeadingZero().find(wrong)
    turn = float(fault.evidence.partition("turned by ")[2].partition(" deg")[0])
    assert np.cos(np.deg2rad(turn + offset)) == pytest.approx(1.0, abs=1e-3)
    assert np.cos(fault.instruments["heading_bias"] - np.deg2rad(offset)) == pytest.approx(1.0, abs=1e-3)
