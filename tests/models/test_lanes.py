"""Blocks of runs against the same runs one by one."""

import numpy as np
import pytest

from helmbench.datasets.manoeuvres import parse_manoeuvre
from helmbench.models import kernels
from helmbench.models.errors import BadInput
from helmbench.models.lanes import closed_loops, open_loops, width
from helmbench.models.model import list_vessels, resolve
from helmbench.models.simulate import closed_loop, initial_state, inputs_of, simulate

MANOEUVRES = ("zigzag:10/5", "zigzag:20/20:port", "sine:10deg/20s+5deg/7s", "turn:15", "prbs:8deg/3s", "zigzag:5/2")
SAMPLES = 121
AGREE = 1e-11
"""Largest difference, as a share of the state's largest value."""


@pytest.fixture(params=list(list_vessels()))
def vessel(request):
    return resolve(request.param)


def assert_same(found, expected):
    scale = np.abs(expected).max(axis=0)
    assert np.all(np.abs(found - expected).max(axis=0) <= AGREE * scale)


def spread(vessel, runs, rng):
    """Coefficients and initial states (runs, .) around the vessel's own."""
    sets = vessel.coefficients * (1.0 + 0.02 * rng.standard_normal((runs, vessel.coefficients.size)))
    starts = initial_state(vessel) * (1.0 + 0.05 * rng.standard_normal((runs, 1)))
    starts[:, vessel.states.index("psi")] = rng.uniform(-3.0, 3.0, runs)
    starts[:, vessel.states.index("r")] = 1e-3 * rng.standard_normal(runs)
    return sets, starts


def controls_of(vessel, texts, dt, rng):
    return [parse_manoeuvre(text).control(vessel, dt, (SAMPLES - 1) * dt, rng) for text in texts]


def test_open_loops_are_simulations(vessel, rng):
    dt, runs = vessel.suite["dt_s"], width(vessel) + 3
    sets, starts = spread(vessel, runs, rng)
    rudder = np.cumsum(rng.normal(0.0, 0.02, (runs, SAMPLES)), axis=1)
    inputs = np.array([inputs_of(vessel, row) for row in rudder])
    together = open_loops(vessel, sets, inputs, dt, starts)
    for run in (0, 1, width(vessel) - 1, width(vessel), runs - 1):
        alone = simulate(vessel.with_coefficients(sets[run]), inputs[run], dt, starts[run])
        assert_same(together[run], alone)


@pytest.mark.parametrize("integrator", ["rk4", "euler"])
def test_closed_loops_are_their_runs(vessel, rng, integrator):
    dt, runs = min(vessel.suite["dt_s"], vessel.max_step_s), width(vessel) - 2
    sets, starts = spread(vessel, runs, rng)
    texts = [*MANOEUVRES, *(["heading:5deg/60s"] if vessel.controller else [])]
    controls = controls_of(vessel, [texts[i % len(texts)] for i in range(runs)], dt, rng)
    together = closed_loops(vessel, dt, controls, sets, starts, integrator=integrator)
    for run in range(runs):
        alone = closed_loop(vessel.with_coefficients(sets[run]), dt, controls[run], None, starts[run], integrator)
        assert_same(together.states[run], alone.states)
        np.testing.assert_allclose(together.rudder_rad[run], alone.rudder_rad, atol=AGREE)
        np.testing.assert_allclose(together.command_rad[run], alone.command_rad, atol=AGREE)


def test_a_zigzag_of_a_block_reverses_more_than_once(rng):
    """The comparison above is of closed loops: each helmsman looks at the heading of his own ship."""
    vessel = resolve("mariner")
    sets, starts = spread(vessel, 8, rng)
    runs = closed_loops(vessel, 0.5, controls_of(vessel, ["zigzag:10/5"] * 8, 0.5, rng)[:8], sets, starts)
    reversals = np.abs(np.diff(np.sign(runs.command_rad), axis=1) == 2).sum(axis=1)
    assert reversals.min() >= 1
    assert len({row.tobytes() for row in runs.command_rad}) > 1


@pytest.mark.parametrize("name", ["mariner", "s175", "kvlcc2-l7"])
def test_weather_acts_as_on_single_runs(name, rng):
    vessel = resolve(name)
    dt, runs = vessel.suite["dt_s"], 5
    sets, starts = spread(vessel, runs, rng)
    weather = 0.05 * vessel.speed_m_s * rng.standard_normal((runs, SAMPLES, 7))
    weather[..., 2:4] *= vessel.windage is not None
    controls = controls_of(vessel, ["zigzag:10/5"] * runs, dt, rng)
    together = closed_loops(vessel, dt, controls, sets, starts, weather)
    for run in range(runs):
        alone = closed_loop(vessel.with_coefficients(sets[run]), dt, controls[run], weather[run], starts[run])
        assert_same(together.states[run], alone.states)


def test_a_rudder_linkage_is_kept(rng):
    from dataclasses import replace

    vessel = replace(resolve("mariner"), instruments={"rudder_delay": 0.7, "rudder_backlash": 0.01})
    sets, starts = spread(vessel, 3, rng)
    controls = controls_of(vessel, ["zigzag:10/5"] * 3, 0.5, rng)
    together = closed_loops(vessel, 0.5, controls, sets, starts)
    for run in range(3):
        alone = closed_loop(vessel.with_coefficients(sets[run]), 0.5, controls[run], None, starts[run])
        np.testing.assert_array_equal(together.states[run], alone.states)


ALONG, ACROSS = np.meshgrid(np.linspace(-2.0, 2.0, 201), np.geomspace(1e-6, 1e3))
LANE_FUNCTIONS = {
    "lane_sin": (np.sin, [np.linspace(-100.0, 100.0, 20_001)]),
    "lane_cos": (np.cos, [np.linspace(-100.0, 100.0, 20_001)]),
    "lane_exp": (np.exp, [np.linspace(-690.0, 690.0, 20_001)]),
    "lane_atan2": (np.arctan2, [ALONG.ravel(), ACROSS.ravel()]),
}
"""Name -> the function it stands for, and where they are compared."""


@pytest.mark.parametrize("name", LANE_FUNCTIONS)
def test_functions_of_a_block_are_those_of_numpy(name):
    exact, at = LANE_FUNCTIONS[name]
    of_block = getattr(kernels._module(kernels.load("mmg")._found["lanes"]), name)
    found = np.array([of_block(*values) for values in zip(*at, strict=True)])
    np.testing.assert_allclose(found, exact(*at), rtol=2e-15, atol=2e-16)


def test_arc_tangents_of_a_block_go_round_the_circle():
    of_block = kernels._module(kernels.load("mmg")._found["lanes"]).lane_atan2
    angles = np.linspace(-3.14, 3.14, 400)
    found = [of_block(np.sin(angle), np.cos(angle)) for angle in angles]
    np.testing.assert_allclose(found, angles, rtol=2e-15, atol=2e-16)
    assert of_block(0.0, 0.0) == 0.0


def test_more_runs_than_a_block_holds_are_refused(rng):
    vessel = resolve("response-1")
    with pytest.raises(BadInput, match="33 runs in a block of 32"):
        closed_loops(vessel, 0.1, controls_of(vessel, ["straight"] * 33, 0.1, rng))
