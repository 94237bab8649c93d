"""Craft that move sideways and turn on the spot: what a ship's course shows of units and signs, theirs does not."""

import numpy as np

from helmbench.checks.check import check
from helmbench.checks.integrity.readings import speed_ratio
from helmbench.datasets.axes import track_of
from helmbench.datasets.geometry import velocity_over_ground
from helmbench.datasets.record import Record, RecordMeta
from helmbench.datasets.signals import integral


def sailed(rng, name="run", turns=6.0):
    """A craft whose velocity in body axes has nothing to do with its heading, and turns on the spot."""
    time, phase = np.arange(600) * 0.2, rng.uniform(0.0, 2.0 * np.pi, 4)
    rate = turns * 2.0 * np.pi / time[-1] + 0.3 * np.sin(0.31 * time + phase[0])
    surge = 0.4 + 0.3 * np.sin(0.17 * time + phase[1])
    sway = 0.4 * np.sin(0.23 * time + phase[2])
    heading = np.concatenate([[0.0], np.cumsum(0.5 * (rate[1:] + rate[:-1]) * np.diff(time))])
    velocity = (surge + 1j * sway) * np.exp(1j * heading)
    place = np.concatenate([[0.0], np.cumsum(0.5 * (velocity[1:] + velocity[:-1]) * np.diff(time))])
    noise = {"heading_rad": 1e-3, "yaw_rate_rad_s": 1e-3, "surge_m_s": 5e-3, "sway_m_s": 5e-3, "north_m": 5e-3}
    true = (heading, rate, surge, sway, place.real, place.imag)
    channels = {
        key: values + noise.get(key, 5e-3) * rng.standard_normal(time.size)
        for key, values in zip((*noise, "east_m"), true, strict=True)
    }
    channels["rudder_command_rad"] = 0.3 * np.sin(0.31 * time + phase[3])
    return Record(time, channels, name, RecordMeta())


def in_radians(record):
    """Heading, from 0 to 2 pi, and yaw rate in radians under names that say degrees."""
    heading = np.deg2rad(np.mod(record.column("heading_rad"), 2.0 * np.pi))
    return record.with_channels(heading_rad=heading, yaw_rate_rad_s=np.deg2rad(record.column("yaw_rate_rad_s")))


def causes(records):
    return {f.cause for f in check(records).findings if f.material}


def test_the_record_as_it_is_has_no_wrong_column(rng):
    assert not causes([sailed(rng)]) & {"wrong_unit", "heading_zero", "channel_sign", "channel_swap", "splice"}


def test_radians_taken_for_degrees_are_a_unit_and_no_turned_heading(rng):
    assert causes([in_radians(sailed(rng))]) == {"wrong_unit"}


def test_radians_are_told_by_the_wraps_where_there_are_no_velocities(rng):
    record = in_radians(sailed(rng))
    angles = ("heading_rad", "yaw_rate_rad_s", "rudder_command_rad")
    alone = Record(record.time_s, {n: record.column(n) for n in angles}, "alone", RecordMeta())
    (found,) = (f for f in check([alone]).findings if f.material)
    assert found.cause == "wrong_unit" and found.standing and "wraps at 0.1097 rad" in found.evidence


def test_a_unit_that_one_record_shows_leaves_no_record_to_be_compared(rng):
    """Another record of the same logger turns too little to show it, and drifts with its heading of a sixtieth."""
    whole, straight = sailed(rng, "whole"), sailed(rng, "straight", turns=0.0)
    few = {n: v[:80] for n, v in straight.channels.items()}
    straight = Record(straight.time_s[:80], few, "straight", RecordMeta())
    found = check([in_radians(whole), in_radians(straight)])
    assert {f.cause for f in found.findings if f.material} == {"wrong_unit"}
    assert any("sensors of straight are not compared" in text for text in found.not_checked)


def test_the_speed_of_a_craft_that_turns_is_compared_along_its_way(rng):
    record = sailed(rng, turns=20.0)
    assert abs(speed_ratio(record) - 1.0) < 0.05
    knots = record.with_channels(**{n: record.column(n) / 0.514444 for n in ("surge_m_s", "sway_m_s")})
    (found,) = (f for f in check([knots]).findings if f.cause == "wrong_unit")
    assert found.material and "knots" in found.evidence


def test_a_speed_that_was_taken_for_knots_is_seen_beside_a_current_and_a_current_is_no_unit(rng):
    record = sailed(rng)
    drift = 0.15 * (record.time_s - record.time_s[0])
    in_current = record.with_channels(north_m=record.column("north_m") + drift)
    assert "wrong_unit" not in causes([in_current])
    slow = {n: record.column(n) * 0.514444 for n in ("surge_m_s", "sway_m_s")}
    (found,) = (f for f in check([in_current.with_channels(**slow)]).findings if f.cause == "wrong_unit")
    assert found.material and "metres per second where knots are meant" in found.evidence


def test_the_unit_of_a_speed_is_seen_without_a_speed_athwart(rng):
    record = sailed(rng)
    ahead = velocity_over_ground(record) * np.exp(-1j * record.heading_unwrapped())
    place = integral(ahead.real * np.exp(1j * record.heading_unwrapped()), record.time_s)
    few = {n: v for n, v in record.channels.items() if n != "sway_m_s"} | {"north_m": place.real, "east_m": place.imag}
    few["surge_m_s"] = few["surge_m_s"] / 0.514444
    (found,) = (f for f in check([Record(record.time_s, few, "few", RecordMeta())]).findings if f.cause == "wrong_unit")
    assert found.channels == ("surge_m_s",) and "knots" in found.evidence


def test_a_track_with_a_tenth_of_its_samples_missing_is_the_same_track(rng):
    time = np.arange(600) * 0.5
    heading = 1.2 * np.sin(0.05 * time)
    place = np.cumsum(np.exp(1j * (heading - 0.1)))
    channels = {"heading_rad": heading, "north_m": place.real, "east_m": place.imag}
    record = Record(time, channels, "run", RecordMeta())
    gaps = {n: np.where(rng.random(time.size) < 0.1, np.nan, v) for n, v in channels.items()}
    for east in (1.0, -1.0):
        whole = track_of(record.with_channels(east_m=east * channels["east_m"]))
        holed = track_of(record.with_channels(**(gaps | {"east_m": east * gaps["east_m"]})))
        assert holed.mirrored == whole.mirrored == (east < 0.0)
        assert abs(holed.angle - whole.angle) < 0.02
