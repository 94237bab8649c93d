"""Simulation against SciPy, exact discretisation, difference equations and closed forms."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from helmbench.models.errors import BadInput
from helmbench.models.model import list_vessels, resolve
from helmbench.models.rudder_chain import steer
from helmbench.models.simulate import (
    ClosedLoop,
    accelerations,
    closed_loop,
    initial_state,
    inputs_of,
    regression,
    sensitivities,
    simulate,
    simulated_states,
    state_matrices,
    step_map,
    zoh_matrices,
)

VESSELS = list(list_vessels())
SAMPLES = 41


@pytest.fixture(params=VESSELS)
def vessel(request):
    return resolve(request.param)


def course(vessel, rng):
    """A random piecewise linear rudder, and a moving start."""
    dt = vessel.suite["dt_s"]
    knots = rng.uniform(-0.2, 0.2, 6)
    rudder = np.interp(np.linspace(0, 5, SAMPLES), np.arange(6), knots)
    x0 = initial_state(vessel)
    if vessel.is_3dof:
        x0[1] = 0.03 * vessel.speed_m_s * rng.standard_normal()
    return dt, inputs_of(vessel, rudder), x0


def test_rk4_agrees_with_an_adaptive_integrator(vessel, rng):
    """With a quarter of the vessel's step: `test_reference_vessels` holds the step itself."""
    dt, inputs, x0 = course(vessel, rng)
    states = simulate(replace(vessel, max_step_s=vessel.max_step_s / 4.0), inputs, dt, x0)
    time = dt * np.arange(SAMPLES)

    def rate(t, x):
        u = np.array([np.interp(t, time, column) for column in inputs.T])
        return accelerations(vessel, x[None], u[None])[0]

    exact = np.array(
        [x0]
        + [
            solve_ivp(rate, (0, end), x0, rtol=1e-10, atol=1e-12, max_step=dt).y[:, -1]
            for end in time[[SAMPLES // 2, SAMPLES - 1]]
        ]
    )
    error = np.abs(states[[0, SAMPLES // 2, SAMPLES - 1]] - exact).max(axis=0)
    assert np.all(error <= 1e-5 * np.abs(states).max(axis=0) + 1e-9)


def test_sensitivities_that_have_faded_are_zero():
    """Not the smallest numbers of the processor, which take several times as long."""
    model = resolve("response-2")
    rudder = 0.2 * np.sin(0.05 * np.arange(60_000))
    dt = model.suite["dt_s"]
    _, columns = sensitivities(model, inputs_of(model, rudder), dt, initial_state(model), initial=(0, 1))
    by_start = np.abs(columns[:, model.states.index("r"), -2:])
    assert (by_start[:100] > 0.0).any() and not by_start[-1].any()
    assert by_start[by_start > 0.0].min() > 1e-200
    assert np.isfinite(columns).all()


def test_sensitivities_agree_with_finite_differences(vessel, rng):
    """At one width at least: wide ones are coarse, and a kink (gamma_R port or starboard) may lie between two runs."""
    dt, inputs, x0 = course(vessel, rng)
    initial = (0, 1)
    states, columns = sensitivities(vessel, inputs, dt, x0, initial=initial)
    np.testing.assert_allclose(states, simulate(vessel, inputs, dt, x0), rtol=1e-9, atol=1e-11)
    p = len(vessel.coordinates)

    def moved(k, step):
        c, start = vessel.coefficients.copy(), x0.copy()
        if k < p:
            c[k] += step
        else:
            start[initial[k - p]] += step
        return simulate(vessel.with_coefficients(c), inputs, dt, start)

    for k in rng.choice(p + len(initial), size=min(8, p), replace=False):
        excess = []
        for width in max(abs(vessel.coefficients[k]) if k < p else 1.0, 1e-2) * np.logspace(-4, -8, 5):
            difference = (moved(k, width) - moved(k, -width)) / (2 * width)
            scale = np.abs(difference).max(axis=0)
            rounding = 1e-14 * np.abs(states).max(axis=0) / width
            error = np.abs(columns[:, :, k] - difference).max(axis=0)
            excess.append(np.max(error - (1e-4 * scale + 1e-6 * scale.max() + rounding)))
        assert min(excess) <= 0, (k, excess)


def test_chosen_columns_are_those_of_the_full_set(rng):
    vessel = resolve("mariner")
    dt, inputs, x0 = course(vessel, rng)
    _, every = sensitivities(vessel, inputs, dt, x0)
    chosen = sorted(rng.choice(60, 7, replace=False).tolist())
    _, some = sensitivities(vessel, inputs, dt, x0, columns=chosen)
    np.testing.assert_allclose(some, every[:, :, chosen], rtol=1e-10, atol=1e-12 * np.abs(every).max())


def test_explicit_euler_is_the_difference_equation(vessel, rng):
    dt, inputs, x0 = course(vessel, rng)
    dt = min(dt, vessel.max_step_s)
    states = simulate(vessel, inputs, dt, x0, integrator="euler")
    rates = accelerations(vessel, states, inputs)[:-1]
    np.testing.assert_allclose(np.diff(states, axis=0) / dt, rates, rtol=1e-6, atol=1e-9)


def test_forward_differences_of_a_difference_equation_regress_exactly(rng):
    """q = r_dot by forward difference and delta_rate likewise: the scheme that least squares uses."""
    vessel = resolve("response-2")
    dt, inputs, x0 = course(vessel, rng)
    states = simulate(vessel, inputs, dt, x0, integrator="euler")
    r, delta = states[:, 1], inputs[:, 0]
    q, rate = np.diff(r) / dt, np.diff(delta) / dt
    rows = np.column_stack([q, r[:-1], states[:-1, 2]])[:-1]
    left, right = regression(vessel, rows, (np.diff(q) / dt)[:, None], np.column_stack([delta[:-1], rate])[:-1])
    np.testing.assert_allclose(right[:, 0] @ vessel.coefficients, left[:, 0], atol=1e-9 * np.abs(left).max())
    hidden = simulated_states(vessel, rows, delta[:-2])
    np.testing.assert_allclose(hidden, states[:-2], atol=1e-9 * np.abs(states).max())


@pytest.mark.parametrize("name", ["nomoto-1", "nomoto-2", "kt", "nomoto-2-steered"])
def test_linear_models_match_their_exact_discretisation(name, rng):
    blank = resolve("cargo" if name == "nomoto-2-steered" else name)
    if name == "nomoto-2-steered":
        blank = steered(blank)
    else:
        stable = {"nomoto-1": (12.0, 0.2), "nomoto-2": (40.0, 5.0, 9.0, 0.1), "kt": (2.0, 1.5, 1.2, 0.8)}[name]
        blank = blank.with_coefficients(blank.from_parameters(stable))
    dt, u = 0.05, rng.uniform(-0.3, 0.3, (200, 1))
    exact_a, exact_b = zoh_matrices(blank, dt)
    x = np.zeros(len(blank.states))
    exact = [x]
    for k in range(199):
        x = exact_a @ x + exact_b @ u[k]
        exact.append(x)
    np.testing.assert_allclose(simulate(blank, u, dt, exact[0], hold="zero"), exact, atol=2e-7 * np.abs(exact).max())


def steered(cargo):
    """The closed-loop model with the vessel's coefficients, controller and steering gear."""
    from dataclasses import replace

    assert cargo.controller is not None
    return replace(
        cargo,
        family="nomoto-2-steered",
        constants=np.array([cargo.controller.kp, cargo.rudder.lag_s]),
        max_step_s=0.1,
    )


def test_a_non_linear_model_has_no_exact_discretisation():
    with pytest.raises(ValueError, match="not a linear model"):
        zoh_matrices(resolve("mariner"), 0.1)


def test_one_step_predictions_follow_the_run(vessel, rng):
    dt, inputs, x0 = course(vessel, rng)
    states = simulate(vessel, inputs, dt, x0)
    np.testing.assert_allclose(step_map(vessel, states[:-1], inputs, dt), states[1:], rtol=1e-9, atol=1e-10)


def test_a_closed_loop_run_repeats_from_its_rudder(vessel):
    dt, count = vessel.suite["dt_s"], 200
    angle = 0.05 * vessel.starboard
    control = ClosedLoop("zigzag", np.zeros(count), vessel.rudder, 5 * dt, angle, 0.02)
    run = closed_loop(vessel, dt, control)
    again = simulate(vessel, inputs_of(vessel, run.rudder_rad), dt, run.states[0])
    np.testing.assert_allclose(again, run.states, rtol=1e-9, atol=1e-9)
    assert np.all(run.command_rad[:5] == 0) and run.command_rad[5] == angle


def test_zigzag_orders_are_given_at_the_heading_that_was_asked_for():
    vessel, dt = resolve("mariner"), 0.5
    angle = np.deg2rad(20)
    control = ClosedLoop("zigzag", np.zeros(1200), vessel.rudder, 10.0, angle * vessel.starboard, angle)
    run = closed_loop(vessel, dt, control)
    switches = np.flatnonzero(np.diff(run.command_rad)) + 1
    heading = np.rad2deg(run.states[:, 5])
    assert run.time_s[switches[0]] == 10.0 and heading[switches[0] : switches[1]].max() > 19.5  # starboard first
    for number, k in enumerate(switches[1:]):
        side = 1 if number % 2 == 0 else -1
        assert side * heading[k] >= 20 > side * heading[k - 1]


@pytest.mark.parametrize("lag", [0.0, 0.7])
@pytest.mark.parametrize("rate", [0.05, np.inf])
def test_the_steering_gear_is_the_exact_solution(lag, rate, rng):
    start, command = rng.uniform(-0.4, 0.4, 2)
    fine, angle = 20000, start
    for _ in range(fine):
        gap = command - angle
        wanted = gap / lag if lag else np.copysign(np.inf, gap)
        move = np.clip(wanted, -rate, rate) / fine
        angle = command if abs(move) >= abs(command - angle) else angle + move
    assert steer(start, command, 1.0, lag, rate, 1.0) == pytest.approx(angle, abs=2e-4)


def test_the_rudder_stops_at_its_largest_angle():
    assert steer(0.0, 2.0, 100.0, 1.0, 0.1, 0.6) == pytest.approx(0.6, abs=1e-9)


def test_a_uniform_current_only_carries_the_ship_along():
    vessel = resolve("mariner")
    count, drift = 400, np.array([0.4, -0.3])
    control = ClosedLoop("zigzag", np.zeros(count), vessel.rudder, 10.0, -0.3, 0.3)
    calm = closed_loop(vessel, 0.5, control)
    environment = np.zeros((count, 7))
    environment[:, :2] = drift
    start = initial_state(vessel)
    start[:2] += drift  # heading north, the same motion through the water
    carried = closed_loop(vessel, 0.5, control, environment, start)
    moved = carried.states[:, 3:5] - calm.states[:, 3:5]
    np.testing.assert_allclose(moved, np.outer(calm.time_s, drift), atol=1e-6)
    np.testing.assert_allclose(carried.states[:, 2], calm.states[:, 2], atol=1e-9)


def test_forces_accelerate_by_their_mass():
    """X on the Mariner: (m - Xudot) rho L^3/2 u_dot = X at rest of all else."""
    vessel = resolve("mariner")
    numbers = dict(zip(vessel.constant_names, vessel.constants, strict=True))
    module, theta = vessel.environment(wind=False)
    rates, calm = np.empty(6), np.empty(6)
    x = initial_state(vessel)
    force = 1.0e6
    module.rhs(x, np.array([0.0, 0, 0, 0, 0, force, 0, 0]), theta, rates)
    vessel.kernels.rhs(x, np.zeros(1), vessel.theta, calm)
    mass = numbers["m11"] * 0.5 * vessel.particulars["rho"] * numbers["L"] ** 3
    assert rates[0] - calm[0] == pytest.approx(force / mass, rel=1e-9)


def test_wind_pushes_the_ship_where_it_blows():
    vessel = resolve("mariner")
    module, theta = vessel.environment(wind=True)
    x = initial_state(vessel)
    calm, blown = np.empty(6), np.empty(6)
    module.rhs(x, np.zeros(8), theta, calm)
    module.rhs(x, np.array([0.0, 0, 0, -8.0, -8.0, 0, 0, 0]), theta, blown)  # from the starboard bow (north-east)
    assert blown[0] < calm[0] and blown[1] < calm[1] and blown[2] < calm[2]  # back, to port, bow to port


def test_a_response_model_has_no_environment():
    vessel = resolve("cargo")
    with pytest.raises(BadInput, match="3-DOF"):
        closed_loop(vessel, 0.5, ClosedLoop("series", np.zeros(20), vessel.rudder), np.ones((20, 7)))


def test_divergence_gives_non_finite_rows_and_no_exception():
    unstable = resolve("nomoto-1").with_coefficients([50.0, 1.0])
    states = simulate(unstable, np.full((5000, 1), 0.1), 1.0, np.zeros(2))
    assert not np.isfinite(states[-1]).any()


def test_linearisation_is_that_of_the_rates(rng):
    vessel = resolve("s175")
    a, b = state_matrices(vessel)
    x, u = initial_state(vessel), inputs_of(vessel, np.zeros(1))[0]
    step = 1e-6 * rng.standard_normal(6)
    moved = accelerations(vessel, [x + step, x - step], [u, u])
    np.testing.assert_allclose((moved[0] - moved[1]) / 2, a @ step, atol=1e-10)
    assert b.shape == (6, 2)
