"""Manoeuvring indices, measured and simulated, against circles and zigzags that are known in closed form."""

import math

import numpy as np
import pytest
from scipy.optimize import brentq

from helmbench.datasets.indices import executes, initial_turning, performed
from helmbench.datasets.record import Record, RecordMeta
from helmbench.estimation.validation.manoeuvres import measured_indices
from helmbench.estimation.validation.validate import validate
from helmbench.models.model import resolve

DEG = math.pi / 180.0


def circle(radius=100.0, speed=5.0, rudder=35.0, side=1.0, execute=20.0, dt=0.1, course=0.7):
    """A ship that sails straight, then without any delay on a circle; velocities and positions exact."""
    time = np.arange(0.0, execute + 1.5 * math.pi * 2.0 * radius / speed, dt)
    turned = np.maximum(time - execute, 0.0) * speed / radius
    ahead = np.minimum(time, execute) * speed + radius * np.sin(turned)
    across = side * radius * (1.0 - np.cos(turned))
    channels = {
        "rudder_rad": np.where(time > execute, side * rudder * DEG, 0.0),
        "heading_rad": course + side * turned,
        "yaw_rate_rad_s": np.where(time > execute, side * speed / radius, 0.0),
        "surge_m_s": np.full(time.size, speed),
        "sway_m_s": np.zeros(time.size),
        "north_m": 40.0 + ahead * math.cos(course) - across * math.sin(course),
        "east_m": -7.0 + ahead * math.sin(course) + across * math.cos(course),
    }
    return Record(time, channels, "circle", RecordMeta(positive_rudder="starboard"))


def swing(gain, time_s, rate, rudder, t):
    """Yaw rate and heading change after t under a constant rudder: r' = (K delta - r)/T."""
    decay = math.exp(-t / time_s)
    return gain * rudder + (rate - gain * rudder) * decay, gain * rudder * t + time_s * (rate - gain * rudder) * (
        1 - decay
    )


def zigzag(gain, time_s, rudder, heading, dt=0.02, execute=10.0, duration=200.0):
    """A first-order ship in an ideal zigzag with a rudder that jumps: record, and its two overshoots, rad."""
    until = brentq(lambda t: swing(gain, time_s, 0.0, rudder, t)[1] - heading, 1e-6, 500.0)
    marks, rate, psi, side, found = [execute], 0.0, 0.0, 1.0, []
    for _ in range(3):
        rate, change = swing(gain, time_s, rate, side * rudder, until)
        psi, side = psi + change, -side
        marks.append(marks[-1] + until)
        turning = time_s * math.log(1.0 + abs(rate) / (gain * rudder))
        found.append(abs(swing(gain, time_s, rate, side * rudder, turning)[1]))
        until = brentq(lambda t, r=rate, p=psi, s=side: p + swing(gain, time_s, r, s * rudder, t)[1] - s * heading,
                       turning, 500.0)  # fmt: skip
    time = np.arange(0.0, duration, dt)
    leg = np.searchsorted(marks, time)
    delta = np.where(leg == 0, 0.0, rudder * np.where(leg % 2 == 1, 1.0, -1.0))
    rates, headings = np.zeros(time.size), np.zeros(time.size)
    start = (0.0, 0.0)
    for place, mark in enumerate(marks):
        own = np.flatnonzero(leg == place + 1)
        size = rudder if place % 2 == 0 else -rudder
        for i in own:
            rates[i], change = swing(gain, time_s, start[0], size, time[i] - mark)
            headings[i] = start[1] + change
        if place + 1 < len(marks):
            rate, change = swing(gain, time_s, start[0], size, marks[place + 1] - mark)
            start = rate, start[1] + change
    last = marks[-1] + 60.0
    keep = time < min(last, duration)
    channels = {"rudder_rad": delta, "yaw_rate_rad_s": rates, "heading_rad": headings}
    record = Record(
        time[keep], {k: v[keep] for k, v in channels.items()}, "zigzag", RecordMeta(positive_rudder="starboard")
    )
    return record, found


# ------------------------------------------------------------------------------------------------ measured


@pytest.mark.parametrize("side", [1.0, -1.0])
def test_a_circle_has_its_radius_as_advance_and_transfer(side):
    record = circle(side=side)
    found = performed(record)
    assert (found.kind, found.title, record.time_s[found.executes[0]]) == ("turn", "turn 35", pytest.approx(20.0))
    values = measured_indices(record, found)[0]
    assert values == pytest.approx({"advance": 100.0, "transfer": 100.0, "tactical_diameter": 200.0}, rel=1e-3)


def test_initial_turning_is_the_way_along_the_arc(rng):
    record = circle(rudder=10.0)
    values = measured_indices(record, performed(record))[0]
    assert values["initial_turning"] == pytest.approx(100.0 * 10.0 * DEG, rel=5e-3)
    noisy = {name: record.column(name) + rng.normal(0.0, 0.1, record.n) for name in ("north_m", "east_m")}
    assert initial_turning(record.with_channels(**noisy), 20.0) == pytest.approx(100.0 * 10.0 * DEG, abs=1.0)
    without = record.with_channels(north_m=None, east_m=None)
    assert initial_turning(without, 20.0) == pytest.approx(100.0 * 10.0 * DEG, rel=5e-3)
    assert "initial_turning" not in measured_indices(circle(rudder=35.0), performed(circle(rudder=35.0)))[0]


def test_a_turn_that_ends_early_has_a_reason():
    record = circle()
    short = record.between(None, 20.0 + 0.6 * math.pi * 100.0 / 5.0)
    values, reasons = measured_indices(short, performed(short))
    assert values["advance"] == pytest.approx(100.0, rel=1e-3)
    assert math.isnan(values["tactical_diameter"])
    assert reasons == {"tactical_diameter": "the record ends before"}


@pytest.mark.parametrize(("rudder", "heading"), [(10.0, 10.0), (20.0, 20.0), (20.0, 10.0)])
def test_overshoots_of_a_first_order_ship_are_those_of_the_formula(rudder, heading):
    record, expected = zigzag(0.1, 15.0, rudder * DEG, heading * DEG)
    found = performed(record)
    assert found.title == f"zigzag {rudder:.0f}/{heading:.0f}" and len(found.executes) >= 3
    values = measured_indices(record, found)[0]
    assert [values["first_overshoot"], values["second_overshoot"]] == pytest.approx(expected[:2], rel=5e-3)


# ------------------------------------------------------------------------------------------------ simulated


@pytest.mark.parametrize(("gain", "time_s"), [(0.1, 15.0), (0.13, 15.0), (0.1, 25.0), (0.06, 8.0)])
def test_the_simulated_ship_sails_the_same_zigzag(gain, time_s):
    """Its own heading gives the orders: the overshoots are those of its own formula, whatever the record's are."""
    record, _ = zigzag(0.1, 15.0, 20.0 * DEG, 20.0 * DEG)
    _, expected = zigzag(gain, time_s, 20.0 * DEG, 20.0 * DEG)
    model = resolve("nomoto-1")
    model = model.with_coefficients(model.from_parameters({"T": time_s, "K": gain}))
    found = validate({"m": model}, {"zigzag": record})
    values = {index.name: index.simulated for index in found.indices}
    assert [values["first_overshoot"], values["second_overshoot"]] == pytest.approx(expected[:2], rel=0.01)


def test_a_ship_that_does_not_turn_far_enough_says_so():
    record, _ = zigzag(0.1, 15.0, 20.0 * DEG, 20.0 * DEG)
    model = resolve("nomoto-1")
    model = model.with_coefficients(model.from_parameters({"T": 15.0, "K": 1e-4}))
    reasons = {index.reason for index in validate({"m": model}, {"zigzag": record}).indices}
    assert reasons == {"the simulated heading does not change by 20 deg"}


# ------------------------------------------------------------------------------------------------ recognised or not


def test_a_measured_rudder_with_noise_and_an_unsteady_approach_is_recognised(rng):
    record, _ = zigzag(0.1, 15.0, 20.0 * DEG, 20.0 * DEG, dt=0.1, execute=40.0)
    time, rudder = record.time_s, record.column("rudder_rad").copy()
    rudder += np.where(time < 35.0, 4.0 * DEG * np.sin(0.3 * time), 0.0) + 0.1 * DEG * rng.standard_normal(time.size)
    marks = record.time_s[executes(record.with_channels(rudder_rad=rudder))]
    assert marks[0] == pytest.approx(40.0, abs=0.3) and len(marks) == len(executes(record))
    found = performed(record.with_channels(rudder_rad=rudder))
    assert found.kind == "zigzag" and found.rudder_rad == pytest.approx(20.0 * DEG, rel=0.02)


@pytest.mark.parametrize(
    ("rudder", "reason"),
    [
        (lambda t: 0.0 * t, "the rudder never moves"),
        (lambda t: 0.3 * np.sin(0.05 * t), "the rudder is not held over: neither a zigzag nor a turning circle"),
        (lambda t: 0.3 * (t > 10.0), "the rudder goes over once and the heading changes by less than 90 deg"),
        (
            lambda t: 0.3 * np.sign(np.sin(0.03 * t**1.5)),
            "the rudder is not put over at equal heading changes to both sides: not a zigzag",
        ),
    ],
)
def test_other_records_are_no_manoeuvre_with_indices(rudder, reason):
    time = np.arange(0.0, 100.0, 0.5)
    heading = np.cumsum(0.02 * np.sin(0.01 * time)) * 0.1
    record = Record(time, {"rudder_rad": rudder(time), "heading_rad": heading}, "other")
    assert performed(record).kind == "" and performed(record).reason == reason
    assert performed(record.with_channels(heading_rad=None)).reason == "the record has no heading"
