"""Response vessels (papers 000, 002, 003) against reference values of an independent implementation."""

from dataclasses import replace

import numpy as np
import pytest

from helmbench.datasets.generator import Case, generate
from helmbench.models.model import Model, resolve
from helmbench.models.simulate import initial_state, simulate, state_matrices, zoh_matrices

DEGREE = np.pi / 180


def zigzag(advance, rudder, heading, samples):
    """Heading (N+1,) and ideal rudder (N+1,) in rad: first order at k = 1, judged on the heading at k - 1."""
    psi, delta, side = np.zeros(samples + 1), np.zeros(samples + 1), 1.0
    for k in range(1, samples + 1):
        if side * psi[k - 1] >= heading:
            side = -side
        delta[k] = side * rudder
        psi[k] = advance(delta, k)
    return psi, delta


def switches(delta, dt):
    return dt * (1 + np.flatnonzero(np.diff(delta)))


# ---- paper 000


def heading_increments(kt, dt, samples):
    """Advances paper 000, eq 8, the difference equation that its regression inverts."""
    t1, t2, gain, t3 = (kt.parameters[name] for name in ("T1", "T2", "K", "T3"))
    y = np.zeros(samples + 3)

    def advance(delta, k):
        now, before = y[k + 1], y[k]
        forcing = dt**3 * gain * delta[k] + dt**2 * t3 * (delta[k] - delta[k - 1])
        y[k + 2] = (2 * now - before + dt * t1 * now + forcing) / (1 + dt**2 * t2 + dt * t1)
        return np.sum(y[: k + 3])

    return advance


def exact(kt, dt):
    """Advances the continuous equation exactly for a rudder held over each sample."""
    a, b = zoh_matrices(kt, dt)
    x = np.zeros(3)

    def advance(delta, k):
        x[:] = a @ x + b[:, 0] * delta[k]
        return x[2]

    return advance


def regress_eq_8(psi, delta, dt):
    """T2, T1, K, T3 by least squares on eq 8."""
    y = np.concatenate([[0.0, 0.0], np.diff(psi, prepend=0.0)])
    now, before, earlier = y[3:], y[2:-1], y[1:-2]
    moved = np.diff(delta)
    h = np.column_stack([-(dt**2) * now, -dt * (now - before), dt**3 * delta[1:], dt**2 * moved])
    return np.linalg.lstsq(h, now - 2 * before + earlier, rcond=None)[0]


def test_remus_kt_zigzag_of_the_difference_equation():
    psi, delta = zigzag(heading_increments(resolve("remus-kt"), 0.1, 200), 20 * DEGREE, 20 * DEGREE, 200)
    np.testing.assert_allclose(switches(delta, 0.1), [0.1, 1.5, 4.0, 6.3, 8.7, 11.1, 13.5, 15.9, 18.3], atol=1e-9)
    assert np.rad2deg(psi[-1]) == pytest.approx(9.799755063983236, rel=1e-9)
    assert np.rad2deg(np.max(np.abs(psi))) == pytest.approx(23.333980512645763, rel=1e-9)
    np.testing.assert_allclose(regress_eq_8(psi, delta, 0.1), [2.9686, 2.2256, 2.2071, 2.2309], rtol=1e-9)


def test_remus_kt_zigzag_of_the_continuous_equation():
    """Regression on eq 8 then misses by far: the samples at which the rudder steps dominate."""
    psi, delta = zigzag(exact(resolve("remus-kt"), 0.1), 20 * DEGREE, 20 * DEGREE, 200)
    expected = [0.1, 1.5, 4.0, 6.2, 8.4, 10.6, 12.8, 15.0, 17.2, 19.4]
    np.testing.assert_allclose(switches(delta, 0.1), expected, atol=1e-9)
    assert np.rad2deg(psi[-1]) == pytest.approx(15.912319156920002, rel=1e-9)
    assert np.rad2deg(np.max(np.abs(psi))) == pytest.approx(24.271707172143373, rel=1e-9)
    published = [12.660951503875642, 2.6591815430890096, 13.012941235906155, 0.2963513664800301]
    np.testing.assert_allclose(regress_eq_8(psi, delta, 0.1), published, rtol=1e-7)


# ---- paper 002: 5/10 zigzag, 200 s at 0.1 s, RK4 with the rudder held


def yaw_rate_of_5_10_zigzag(name):
    """Yaw rate (N+1,) and rudder (N+1,): judged at the same sample, one RK4 step a sample."""
    model = replace(resolve(name), max_step_s=0.1)
    psi, r = model.states.index("psi"), model.states.index("r")
    states, delta, side = [initial_state(model)], np.zeros(2001), 1.0
    for k in range(2000):
        if side * states[k][psi] >= 10 * DEGREE:
            side = -side
        delta[k] = side * 5 * DEGREE if k else 0.0
        states.append(simulate(model, [[delta[k]]] * 2, 0.1, states[k], hold="zero")[1])
    return np.array(states)[:, r], delta


def test_response_1_noise_free_forward_differences():
    r, delta = yaw_rate_of_5_10_zigzag("response-1")
    a1, a2, b1 = np.linalg.lstsq(np.column_stack([r[:-1], r[:-1] ** 3, delta[:-1]]), r[1:], rcond=None)[0]
    t = 0.1 / (1 - a1)
    expected = [13.567345568117169, 0.21599763092445412, 258.3423805301469]
    np.testing.assert_allclose([t, b1 * t / 0.1, -a2 * t / 0.1], expected, rtol=1e-9)


def test_response_2_noise_free_forward_differences():
    r, delta = yaw_rate_of_5_10_zigzag("response-2")
    columns = [r[1:-1], r[:-2], r[:-2] ** 3, delta[1:-1], delta[:-2]]
    a1, a2, a3, b1, b2 = np.linalg.lstsq(np.column_stack(columns), r[2:], rcond=None)[0]
    h = 0.01 / (1 - a1 - a2)
    gain = (b1 + b2) * h / 0.01
    found = [h, (2 - a1) * h / 0.1, -a3 * h / 0.01, b1 * h / (gain * 0.1), gain]
    expected = [8.88853421887575, 16.240216538241842, 98.32122369399988, 0.36399627844042104, 0.20100179341201774]
    np.testing.assert_allclose(found, expected, rtol=1e-9)


# ---- paper 003: heading reference of three sines (10, 6, 4 deg), P-controller, steering gear

SINES = {"cargo": (0.0105, 0.031, 0.083), "patrol": (0.12, 0.5, 1.6)}
DURATION_S = {"cargo": 6000, "patrol": 900}


def steered(name):
    vessel = resolve(name)
    assert vessel.controller is not None
    constants = np.array([vessel.controller.kp, vessel.rudder.lag_s])
    return Model(name, "nomoto-2-steered", vessel.coefficients, constants)


def reference(name, time):
    sines = zip((10, 6, 4), SINES[name], strict=True)
    return sum(size * DEGREE * np.sin(frequency * time) for size, frequency in sines)


@pytest.mark.parametrize(
    ("name", "real", "pair"),
    [
        ("cargo", [-0.205735, -0.161057], -0.011048 + 0.010926j),
        ("patrol", [-3.141326, -1.103201], -0.190079 + 0.127847j),
    ],
)
def test_closed_loop_poles(name, real, pair):
    poles = np.linalg.eigvals(state_matrices(steered(name))[0])
    np.testing.assert_allclose(np.sort_complex(poles), [*real, pair.conjugate(), pair], atol=1e-6)


def test_patrol_gain_as_printed_is_unstable():
    model = steered("patrol")
    printed = replace(model, constants=model.constants * [-1.0, 1.0])
    assert np.max(np.linalg.eigvals(state_matrices(printed)[0]).real) > 0.0


@pytest.mark.parametrize(
    ("name", "theta"),
    [
        ("cargo", [-0.1888889, -0.0037037, 0.0033333, 0.00033333]),
        ("patrol", [-3.624685, -1.506895, -0.0475413, -0.2597887]),
    ],
)
def test_regression_vector(name, theta):
    vessel = resolve(name)
    named = dict(zip(vessel.coordinates, vessel.coefficients, strict=True))
    np.testing.assert_allclose([named[key] for key in ("a1", "a2", "b2", "b1")], theta, rtol=2e-5)


@pytest.mark.parametrize(
    ("name", "deviations"),
    [
        ("cargo", [0.1133703, 0.001295536, 2.484121e-5, 1.199810e-6, 0.01853321]),
        ("patrol", [0.1086522, 0.01444216, 0.003796977, 0.002718051, 0.0962778]),
    ],
)
def test_standard_deviations_of_the_three_sine_run(name, deviations):
    """Exact zero-order hold at 0.02 s, all samples but the last: psi, r, r_dot, r_ddot, rudder."""
    model, dt, samples = steered(name), 0.02, DURATION_S[name] * 50
    time = dt * np.arange(samples)
    psi_set = reference(name, time)
    states = held(model, psi_set, dt)
    q, r, psi, delta = states.T
    a1, a2, b1, b2 = model.coefficients
    gain, lag = model.constants
    third = a1 * q + a2 * r + b1 * delta + b2 * (gain * (psi_set - psi) - delta) / lag
    np.testing.assert_allclose([np.std(channel) for channel in (psi, r, q, third, delta)], deviations, rtol=1e-5)


def held(model, inputs, dt):
    """States (N, 4) of the linear model for an input (N,) held over each sample, from rest."""
    a, b = zoh_matrices(model, dt)
    states = np.zeros((inputs.size, 4))
    for k in range(inputs.size - 1):
        states[k + 1] = a @ states[k] + b[:, 0] * inputs[k]
    return states


@pytest.mark.parametrize("name", SINES)
def test_a_steered_record_is_the_steered_equation(name):
    """The helmsman acts at samples: the difference to the continuous loop is of the order of the step."""
    tones = "+".join(f"{size}deg/{w}rad_s" for size, w in zip((10, 6, 4), SINES[name], strict=True))
    duration = DURATION_S[name] / 10
    record = generate(Case(name, f"heading:{tones}", duration_s=duration, dt_s=0.02))
    psi = held(steered(name), reference(name, record.time_s), 0.02)[:, 2]
    assert np.max(np.abs(record.column("heading_rad") - psi)) < 0.01 * np.max(np.abs(psi))
