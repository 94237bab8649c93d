"""A rudder that goes beyond the ship's stops holds another angle; one at its stops does not."""

import numpy as np
import pytest

import helmbench
from helmbench.estimation.diagnosis_only.rudder_scale import rudder_doubt


@pytest.fixture(scope="module")
def turn():
    return helmbench.simulate("kvlcc2-l7", "turn:35", duration_s=60.0, dt_s=0.5, noise="low", seed=1)


def with_rudder(record, factor):
    names = [n for n in ("rudder_rad", "rudder_command_rad") if record.has(n)]
    return record.with_channels(**{n: factor * record.column(n) for n in names})


@pytest.mark.parametrize("factor", [1.2, 2.0])
def test_a_rudder_beyond_the_stops_is_told(turn, factor):
    found = rudder_doubt([with_rudder(turn, factor)], helmbench.resolve("kvlcc2-l7"))
    assert found is not None and found.standing and found.cause == "wrong_unit"
    assert "stops of kvlcc2-l7 at 35 deg" in found.evidence and f"reaches {35 * factor:.2g}" in found.evidence


def test_a_rudder_at_its_stops_is_not(turn, rng):
    noisy = turn.with_channels(rudder_rad=turn.rudder() + np.deg2rad(1.0) + rng.normal(0.0, 0.005, turn.n))
    assert rudder_doubt([turn, noisy], helmbench.resolve("kvlcc2-l7")) is None


def test_a_model_without_stops_has_no_limit(turn):
    assert rudder_doubt([with_rudder(turn, 2.0)], helmbench.resolve("nomoto-1")) is None


@pytest.mark.parametrize(("factor", "said"), [(0.4, "half"), (0.5, "half"), (2.0, "twice"), (1.0, None), (1.3, None)])
def test_free_runs_tell_another_angle(factor, said):
    run = helmbench.simulate("response-1", "zigzag:15/15", duration_s=300.0, dt_s=1.0, noise="low", seed=1)
    found = rudder_doubt([with_rudder(run, factor)], helmbench.resolve("response-1"))
    assert found is None if said is None else f"the rudder is {said} what the yaw rate shows" in found.evidence


def test_forgotten_damping_is_no_other_angle():
    """Free runs without the cubic damping turn far too fast; less rudder hides that, but does not follow."""
    ship = helmbench.resolve("response-1")
    linear = ship.with_coefficients([*ship.coefficients[:2], 0.0])
    runs = [helmbench.simulate("response-1", m, duration_s=400.0, dt_s=1.0, noise="low", seed=1)
            for m in ("zigzag:20/20", "turn:35", "zigzag:30/30:port")]  # fmt: skip
    assert rudder_doubt(runs, linear) is None


@pytest.mark.parametrize("begins_s", [250.0, 260.0, 268.0, 370.0])
def test_a_part_that_begins_in_a_turn_is_no_other_angle(begins_s):
    """Of the mariner's sway at the start nothing is known there; the motion of the last part is that of its start."""
    noise = "low,yaw_rate.bias=0.05deg_s,without=sway+surge+north+east"
    run = helmbench.simulate("mariner", "zigzag:20/20", duration_s=400.0, noise=noise, seed=1)
    assert rudder_doubt([run.between(begins_s, 400.0)], helmbench.resolve("mariner")) is None
