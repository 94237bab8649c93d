"""How the yaw rate answers what steers: told by a response that comes later than the helm, and not by feedback."""

import numpy as np
import pytest

from helmbench.datasets.measured import load, missing_files, stems
from helmbench.datasets.record import Record
from helmbench.datasets.yaw_response import SIGN_SHARE, steering_side, yaw_response

SURE = SIGN_SHARE
TIME = np.arange(0.0, 400.0, 0.5)


def gusts(rng, lag_s):
    """A force (N,) that changes slowly, of standard deviation 1."""
    kept, noise = np.exp(-0.5 / lag_s), rng.normal(size=TIME.size)
    force = np.zeros(TIME.size)
    for i in range(1, TIME.size):
        force[i] = kept * force[i - 1] + np.sqrt(1.0 - kept**2) * noise[i]
    return force


def steered(force, order, gain=0.1, constant_s=8.0, dead_s=0.0):
    """(yaw rate, rudder) of a first-order ship that a force turns as well; `order` of time, heading and yaw rate."""
    rate, rudder, psi, late = np.zeros(TIME.size), np.zeros(TIME.size), 0.0, round(dead_s / 0.5)
    orders = [0.0] * (late + 1)
    for i in range(TIME.size - 1):
        orders.append(order(TIME[i], psi, rate[i]))
        rudder[i] = orders[-1 - late]
        rate[i + 1] = rate[i] + 0.5 * (gain * rudder[i] + force[i] - rate[i]) / constant_s
        psi += 0.5 * rate[i]
    rudder[-1] = rudder[-2]
    return rate, rudder


@pytest.mark.parametrize("gain", [0.1, -0.1])
def test_the_sign_of_the_gain_is_told_under_gusts_and_noise(rng, gain):
    rate, rudder = steered(0.01 * gusts(rng, 20.0), lambda t, psi, r: 0.3 * np.sign(np.sin(t / 9.0)), gain)
    told = yaw_response(TIME, rate + rng.normal(0.0, 0.005, TIME.size), rudder)
    assert told is not None and told.is_sure(SURE) and told.gain == np.sign(gain)


def test_gain_and_share_do_not_depend_on_units_or_a_neutral_angle(rng):
    rate, rudder = steered(0.01 * gusts(rng, 20.0), lambda t, psi, r: 0.3 * np.sign(np.sin(t / 9.0)))
    told, other = yaw_response(TIME, rate, rudder), yaw_response(TIME, 60.0 * rate, 0.2 + 57.3 * rudder)
    assert told is not None and other is not None
    assert (other.gain, other.share, other.beyond) == pytest.approx((told.gain, told.share, told.beyond))


def test_a_helm_that_answers_the_yaw_rate_at_once_tells_nothing(rng):
    """Damping by the helm is a good likeness of the yaw rate, turned round: it explains it, but not later."""
    rate, rudder = steered(0.05 * gusts(rng, 20.0), lambda t, psi, r: -4.0 * r, gain=0.02)
    told = yaw_response(TIME, rate, rudder)
    assert told is not None and told.share > 0.9 and told.gain == -1.0 and not told.is_sure(SURE)


def test_an_autopilot_under_gusts_never_turns_the_sign(rng):
    """Ships that keep a course with gains drawn at random: what is told is to starboard."""
    told = []
    for _ in range(40):
        p, d, dead = rng.uniform(0.2, 3.0), rng.uniform(0.0, 20.0), rng.choice([0.0, 1.0, 2.0])
        force = rng.uniform(0.005, 0.03) * gusts(rng, rng.choice([2.0, 8.0, 60.0]))
        rate, rudder = steered(force, lambda t, psi, r, p=p, d=d: -p * psi - d * r, dead_s=dead)
        response = yaw_response(TIME, rate + rng.normal(0.0, 0.001, TIME.size), np.clip(rudder, -0.6, 0.6))
        told += [response.gain] if response is not None and response.is_sure(SURE) else []
    assert all(gain == 1.0 for gain in told)


@pytest.mark.parametrize("turned", [1.0, -1.0])
def test_a_noisy_heading_of_a_small_craft_under_an_autopilot_tells_the_side(rng, turned):
    """Courses are changed in gusts; the heading alone is logged, with a noise of .35 deg."""

    def order(t, psi, r):
        return float(np.clip(0.6 * np.sign(np.sin(t / 25.0)) - psi - 2.0 * r, -0.5, 0.5))

    rate, rudder = steered(0.03 * gusts(rng, 5.0), order, gain=0.25, constant_s=2.5, dead_s=0.5)
    heading = 0.5 * np.cumsum(rate) + rng.normal(0.0, 0.006, TIME.size)
    told = steering_side(Record(TIME, {"rudder_rad": turned * rudder, "heading_rad": heading}))
    assert told is not None and told[0] == ("starboard" if turned > 0.0 else "port")


def test_a_track_without_a_heading_tells_the_side(rng):
    rate, rudder = steered(0.01 * gusts(rng, 20.0), lambda t, psi, r: 0.3 * np.sign(np.sin(t / 9.0)))
    course = 0.5 * np.cumsum(rate)
    north, east = (3.0 * 0.5 * np.cumsum(turn(course)) for turn in (np.cos, np.sin))
    told = steering_side(Record(TIME, {"rudder_rad": rudder, "north_m": north, "east_m": east}))
    assert told is not None and told[0] == "starboard"


def test_what_never_moves_or_is_too_short_has_no_response(rng):
    rate = rng.normal(size=TIME.size)
    assert yaw_response(TIME, rate, np.full(TIME.size, 0.1)) is None
    assert yaw_response(TIME, np.zeros(TIME.size), rate) is None
    assert yaw_response(TIME[:15], rate[:15], rate[:15]) is None


def test_huge_numbers_and_gaps_are_no_trouble(rng):
    rate, rudder = steered(0.01 * gusts(rng, 20.0), lambda t, psi, r: 0.3 * np.sign(np.sin(t / 9.0)))
    rate[100:120] = np.nan
    told = yaw_response(TIME, 1e300 * rate, 1e-300 * rudder)
    assert told is not None and told.is_sure(SURE) and told.gain == 1.0


@pytest.mark.parametrize("source", ["kvlcc2-hsva", "kvlcc2-marin", "esso-osaka"])
def test_no_measured_run_is_told_wrongly(source):
    """Of the sets that are on this machine."""
    if missing_files(source):
        return
    sides = {stem: steering_side(load(source, stem).turned("starboard")) for stem in stems(source)}
    assert {stem: side for stem, side in sides.items() if side is not None and side[0] != "starboard"} == {}
    assert sum(side is not None for side in sides.values()) >= len(sides) - 1


def test_manoeuvres_of_minutes_are_told_in_a_log_of_days():
    time = np.arange(0.0, 300_000.0, 1.0)
    rudder = 0.3 * np.sign(np.sin(time / 20.0) + np.sin(time / 33.0))
    rate = np.zeros(time.size)
    for i in range(1, time.size):
        rate[i] = 0.9 * rate[i - 1] + 0.01 * rudder[i - 1]
    told = yaw_response(time, rate, rudder)
    assert told is not None and told.is_sure(SURE) and told.gain == 1.0
