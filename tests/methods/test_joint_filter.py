"""The joint filter against a Kalman filter in NumPy, a linear regression, and simulated process noise."""

import numpy as np
import pytest

from helmbench.datasets.record import Record
from helmbench.estimation.records.series import series_of
from helmbench.methods import kalman as joint
from helmbench.methods.kalman import CoefficientDensity, NoiseVariances, smoothed_start
from helmbench.models.model import resolve
from helmbench.models.simulate import initial_state, inputs_of, sensitivities, simulate

from ..made_up.records import driven


@pytest.fixture
def linear(rng):
    """A linear model, a noisy record of it, and the noise assumed."""
    model = resolve("remus-kt")
    clean = driven(model, 0.2 * np.sin(0.4 * np.arange(80)) + 0.05, 0.1)
    sd = {"yaw_rate_rad_s": 0.02, "heading_rad": 0.01}
    record = clean.with_channels(**{k: clean.column(k) + v * rng.normal(size=80) for k, v in sd.items()})
    heading = record.column("heading_rad").copy()
    heading[20:25] = np.nan
    series = series_of(record.with_channels(heading_rad=heading), model)
    noise = NoiseVariances(1.0, np.array([1e-4, 1e-5, 1e-6]), np.array([0.0, 0.02, 0.01]) ** 2)
    return model, clean, series, noise


def _transition(model, series, k):
    states, columns = sensitivities(
        model, series.inputs[k : k + 2], series.dt, np.zeros(3), columns=[], initial=[0, 1, 2]
    )
    return columns[-1], states[-1]


def _kalman(model, series, noise):
    """Textbook Kalman filter and RTS smoother; innovations, negative log likelihood and smoothed states."""
    x, p, cost = series.start.copy(), np.diag(series.start_sd**2), 0.0
    x[0] -= model.coefficients[model.kernels.RATE_GAIN] * series.inputs[0, 0]
    filtered, predicted, maps, innovations = [], [], [], []
    for k in range(len(series.inputs)):
        predicted.append((x, p))
        known = np.isfinite(series.outputs[k])
        h = np.eye(3)[series.columns[known]]
        innovation = series.outputs[k][known] - h @ x
        innovations.append(innovation[0])
        s = h @ p @ h.T + np.diag(noise.sensor[series.columns[known]])
        gain = p @ h.T @ np.linalg.inv(s)
        cost += 0.5 * (np.linalg.slogdet(s)[1] + innovation @ np.linalg.solve(s, innovation))
        x, p = x + gain @ innovation, (np.eye(3) - gain @ h) @ p
        filtered.append((x, p))
        if k + 1 < len(series.inputs):
            f, push = _transition(model, series, k)
            maps.append(f)
            x, p = f @ x + push, f @ p @ f.T + np.diag(noise.process)
    smoothed = [filtered[-1][0]]
    for k in range(len(maps) - 1, -1, -1):
        gain = filtered[k][1] @ maps[k].T @ np.linalg.inv(predicted[k + 1][1])
        smoothed.append(filtered[k][0] + gain @ (smoothed[-1] - predicted[k + 1][0]))
    return np.array(innovations), cost, np.array(smoothed[::-1])


def test_filter_and_smoother_are_kalman_s(linear):
    """Fixed coefficients of a linear model: the same as the textbook recursions, gap included."""
    model, _, series, noise = linear
    fixed = CoefficientDensity.fixed(model.coefficients)
    found = joint.filter_record(model, series, fixed, noise)
    innovations, cost, smoothed = _kalman(model, series, noise)
    assert found.innovations[:, 0] == pytest.approx(innovations, rel=1e-9, abs=1e-12)
    assert found.cost == pytest.approx(cost, rel=1e-10)
    assert np.isnan(found.innovations[20:25, 1]).all() and np.isfinite(found.innovations[:, 0]).all()
    assert smoothed_start(model, series, noise) == pytest.approx(smoothed[0], rel=1e-8, abs=1e-11)


def test_the_smoother_is_more_accurate_than_the_sensors(linear):
    model, clean, series, _ = linear
    noise = NoiseVariances(1.0, np.full(3, 1e-12), np.array([0.0, 0.02, 0.01]) ** 2)
    smoothed = smoothed_start(model, series, noise)
    for i, channel, sd in ((1, "yaw_rate_rad_s", 0.02), (2, "heading_rad", 0.01)):
        assert abs(smoothed[i] - clean.column(channel)[0]) < 0.5 * sd


def test_joint_filter_solves_a_linear_regression(rng):
    """r_dot = k delta: the joint problem is linear, so one pass is the exact posterior of k."""
    model = resolve("integrator").with_coefficients([0.02])
    rudder = 0.3 * np.sin(0.05 * np.arange(400))
    states = simulate(model, inputs_of(model, rudder), 0.1, initial_state(model))
    rate = states[:, 0] + 0.003 * rng.normal(size=400)
    series = series_of(Record(0.1 * np.arange(400), {"rudder_rad": rudder, "yaw_rate_rad_s": rate}), model)
    noise = NoiseVariances(0.0, np.zeros(2), np.array([0.003**2, 0.0]))
    prior = CoefficientDensity.prior(np.array([0.01]), np.array([[0.05]]))
    found = joint.filter_record(model.blanked(), series, prior, noise).density
    area = np.concatenate([[0.0], np.cumsum((rudder[1:] + rudder[:-1]) / 2.0 * 0.1)])
    design = np.column_stack([area, np.ones(400)]) / 0.003
    prior = np.diag([1.0 / 0.05**2, 1.0 / series.start_sd[0] ** 2])
    information = design.T @ design + prior
    mean = np.linalg.solve(information, design.T @ rate / 0.003 + prior @ [0.01, series.start[0]])
    assert found.coefficients[0] == pytest.approx(mean[0], rel=1e-9)
    assert found.coefficient_covariance[0, 0] == pytest.approx(np.linalg.inv(information)[0, 0], rel=1e-7)


def test_process_noise_is_found(rng):
    """A random yaw acceleration: the likeliest process noise has its size, and is nearly zero without it."""
    model, dt, n = resolve("response-1"), 0.2, 2000
    rudder = 0.3 * np.sign(np.sin(0.02 * np.arange(n)))
    for kick in (0.0, 1e-3):
        x, states = initial_state(model), []
        for k in range(n):
            states.append(x)
            last = min(k + 1, n - 1)
            x = simulate(model, inputs_of(model, rudder[[k, last]]), dt, x)[1] + kick * rng.normal() * np.array([1, 0])
        rate, heading = np.array(states).T + 1e-4 * rng.normal(size=(2, n))
        record = Record(dt * np.arange(n), {"rudder_rad": rudder, "yaw_rate_rad_s": rate, "heading_rad": heading})
        series = [series_of(record, model)]
        change = joint.square_changes(model, series)
        _, noise = joint.best_noise(model, series, change, np.array([1e-8, 1e-8]))
        found = np.sqrt(noise.process[0])
        assert (0.3 < found / kick < 3.0) if kick else found < 1e-4
