"""Response models of craft that go ahead and astern."""

from dataclasses import replace

import numpy as np
import pytest

from helmbench.models.extend import extended
from helmbench.models.model import resolve
from helmbench.models.simulate import accelerations

SPEED, RATE, RUDDER = 1.7, 0.2, 0.3
NUMBERS = {"a": -0.3, "a1": -0.4, "b": 0.2, "b2": 0.09, "bn": 0.01, "bs": 0.05, "c": 0.03}


def moment(family, speed, rate, rudder):
    """Yaw acceleration of a model with NUMBERS, the propellers at rest."""
    model = resolve(family)
    model = model.with_coefficients(np.array([NUMBERS[name] for name in model.coordinates]))
    inputs = np.array([[{"delta": rudder, "speed": speed}.get(name, 0.0) for name in model.inputs]])
    return float(accelerations(model, np.array([[rate, 0.0]]), inputs)[0, 0])


@pytest.mark.parametrize(
    ("family", "turned"),
    [
        ("rudder-in-flow", NUMBERS["b2"] * SPEED**2 * RUDDER),
        ("rudder-in-race", NUMBERS["b2"] * SPEED**2 * RUDDER),
        ("rudder-in-steady-race", NUMBERS["b2"] * SPEED**2 * RUDDER),
        ("thruster-in-flow", 0.0),
        ("twin-thrusters", 0.0),
        ("azimuth-thruster", 0.0),
    ],
)
def test_astern_a_rudder_turns_the_craft_to_the_other_side_and_damping_stays(family, turned):
    ahead, astern = (moment(family, side * SPEED, 0.0, RUDDER) for side in (1.0, -1.0))
    assert ahead - astern == pytest.approx(2.0 * turned)
    slower = [moment(family, side * SPEED, RATE, 0.0) - moment(family, side * SPEED, 0.0, 0.0) for side in (1.0, -1.0)]
    assert slower[0] == pytest.approx(slower[1]) and slower[0] < NUMBERS["a1"] * SPEED * RATE + 1e-12


def test_a_speed_of_its_own_has_the_sign_of_surge_and_still_damping_acts_at_rest():
    flow = resolve("rudder-in-flow").with_coefficients(np.array([NUMBERS["a1"], NUMBERS["b2"]]))
    own = {"speed_drive": 0.1, "speed_drag": 0.1, "turn_drag": 0.0, "sway_lever": 0.0, "sway_time": 1.0}
    model = extended(replace(flow, speed_m_s=SPEED), "own_speed", own)

    def turning(surge, sway):
        known = {"r": 0.0, "psi": 0.0, "u": surge, "v": sway}
        state = np.array([[known[name] for name in model.states]])
        return float(accelerations(model, state, np.array([[RUDDER]]))[0, 0])

    assert turning(-3.0, 4.0) == pytest.approx(-NUMBERS["b2"] * 25.0 * RUDDER)
    assert turning(3.0, 4.0) == pytest.approx(NUMBERS["b2"] * 25.0 * RUDDER)
    braked = extended(flow, "still_damping", {"still_damping": 0.05})
    assert accelerations(braked, np.array([[RATE, 0.0]]), np.array([[0.0, 0.0]]))[0, 0] == pytest.approx(-0.05 * RATE)
