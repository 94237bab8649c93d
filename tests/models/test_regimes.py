"""Numbers that differ in a regime: the extension of the equations, and runs that blend two sets of numbers."""

import numpy as np
import pytest

from helmbench.models.coefficient_groups import local_numbers
from helmbench.models.extend import extended
from helmbench.models.families.extensions import OFFSET, regime_parameters
from helmbench.models.lanes import open_loops
from helmbench.models.model import resolve
from helmbench.models.regimes import Regime, regime, values_of
from helmbench.models.simulate import initial_state, inputs_of, simulate

CASES = [
    ("cargo", "rudder_force", "rudder", "above", 0.2, -0.3), ("cargo", "a2", "time", "above", 200.0, 0.3),
    ("response-1", OFFSET, "side", "port", 0.0, 0.05), ("s175", "w_P", "drift", "above", 0.08, 0.3),
    ("s175", "Xuu", "speed", "below", 7.0, 0.3),
]  # fmt: skip


@pytest.mark.parametrize(("vessel", "number", "variable", "side", "threshold", "size"), CASES)
def test_the_extension_and_the_blended_run_agree(vessel, number, variable, side, threshold, size):
    model, where = resolve(vessel), regime(variable, side, threshold, 0.01 if variable == "side" else None)
    name = f"regime_{number}_{variable}_{side}"
    values = dict(zip(regime_parameters(name), (size, threshold, where.width), strict=True))
    whole = extended(model, name, values)
    base = extended(model, OFFSET) if number == OFFSET else model
    (local,) = [n for n in local_numbers(base) if n.name == number]
    names, inside = [*base.coordinates, *base.constant_names], base.theta
    for one, change in local.change.items():
        inside[names.index(one)] += size * change
    inputs = inputs_of(base, 0.4 * np.sin(np.arange(400.0) / 40.0))
    one_run = (base.theta[None], inputs[None], 1.0, initial_state(base)[None], inside[None], [where])
    (states,) = open_loops(base, *one_run)
    plain = simulate(base, inputs, 1.0, initial_state(base))
    grown = simulate(whole, inputs, 1.0, initial_state(whole))[:, : states.shape[1]]
    heading = base.states.index("psi")
    assert np.max(np.abs(states - plain)[:, heading]) > 1e-3
    assert grown == pytest.approx(states, abs=1e-3 * np.max(np.abs(states - plain)))


def test_the_indicator_rises_at_the_threshold():
    x = np.linspace(0.0, 1.0, 101)
    above, below = regime("rudder", "above", 0.5), regime("rudder", "below", 0.5)
    assert above.inside(x)[50] == 0.5 and np.all(np.diff(above.inside(x)) > 0.0)
    assert above.inside(x) + below.inside(x) == pytest.approx(1.0)
    assert np.all(above.inside(x[x > 0.6]) > 0.99) and np.all(above.inside(x[x < 0.4]) < 0.01)


def test_where_a_regime_is_in_words():
    assert Regime("rudder", "above", np.deg2rad(15.0), 0.01).told(np.deg2rad(13.0), np.deg2rad(17.0)) == (
        "beyond 15 deg of rudder (13 to 17)"
    )
    assert Regime("speed", "below", 7.0, 0.1).told(6.5, 7.25) == "below 7 m/s (6.5 to 7.25)"
    assert Regime("side", "port", 0.0, 0.1).told(0.0, 0.0) == "in turns to port"


def test_variables_that_a_model_has_no_states_for_are_left_out():
    line = np.linspace(-1.0, 1.0, 5)
    assert set(values_of({"r": line}, line, line)) == {"rudder", "yaw_rate", "side", "time"}
    found = values_of({"u": np.ones(5), "v": -line, "r": line}, line, line)
    assert found["drift"] == pytest.approx(np.arctan(np.abs(line))) and np.all(found["rudder"] >= 0.0)


def test_mass_has_no_regime():
    names = {n.name for n in local_numbers(resolve("kvlcc2-l7"))}
    assert {"f_alpha", "w_P0", OFFSET} <= names and not names & {"m_x", "I_zz", "nabla", "D_P"}
    (force,) = [n for n in local_numbers(resolve("mariner")) if n.name == "rudder_force"]
    assert all("d" in name for name in force.change) and {"Yd", "Nd", "Xdd"} <= force.change.keys()
