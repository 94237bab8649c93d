"""The innovations filter against a textbook Kalman filter, plain NumPy and the simulator."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.linalg import expm

from helmbench.datasets.generator import Case, generate
from helmbench.datasets.record import Record
from helmbench.datasets.sensors import NOISE
from helmbench.estimation.filters.innovations.estimator import estimator
from helmbench.estimation.filters.innovations.settings import Noise, Setting
from helmbench.estimation.filters.innovations.vector import SENSORS
from helmbench.models.model import resolve
from helmbench.models.simulate import initial_state, inputs_of, simulate

SDS = {"heading_rad": np.deg2rad(0.02), "yaw_rate_rad_s": np.deg2rad(0.01)}
T, K = 12.0, 0.08


@pytest.fixture
def linear(rng):
    """First-order Nomoto model and a noisy record of it with gaps, under gusts that the filter knows."""
    model = resolve("nomoto-1")
    model = model.with_coefficients(model.from_parameters({"T": T, "K": K}))
    n, dt = 400, 0.2
    rudder = 0.3 * np.sin(0.02 * np.arange(n)) + 0.02
    states = simulate(model, inputs_of(model, rudder), dt, initial_state(model))
    r, psi = (states[:, model.states.index(s)] for s in ("r", "psi"))
    r = r + 2e-4 * np.cumsum(rng.normal(size=n)) * 0.1 + SDS["yaw_rate_rad_s"] * rng.normal(size=n)
    psi = psi + SDS["heading_rad"] * rng.normal(size=n)
    r[50:60], psi[120:121] = np.nan, np.nan
    noisy = rudder + 1e-4 * rng.normal(size=n)
    record = Record(dt * np.arange(n), {"rudder_rad": noisy, "yaw_rate_rad_s": r, "heading_rad": psi})
    est = estimator(model, [record])
    sd = np.array([SDS["heading_rad"], SDS["yaw_rate_rad_s"], 1.0, 1.0, 1.0, 1.0])
    noise = Noise(sd, np.array([3e-4 / est.unit[0]]), 7.0)
    return est.with_corners(0.0), Setting(est.start().vectors, noise)


def _textbook(est, s):
    """Kalman filter of (r, psi, force): innovations and log S / 2 of heading and rate, measured one after the other."""
    d, dt, nf = est.segments[0], est.segments[0].time[1], 2
    a = np.array([[-1.0 / T, 0.0, 1.0], [1.0, 0.0, 0.0], [0.0, 0.0, 0.0]])
    whole = np.zeros((5, 5))
    whole[:3, :3], whole[0, 3], whole[3, 4] = a, K / T, 1.0
    step = expm(whole * dt)
    decay, force = np.exp(-dt / s.noise.correlation_time_s), (s.noise.force_sd[0] * est.unit[0]) ** 2
    f = step[:3, :3].copy()
    f[2, 2] = decay
    q = np.diag([1e-14, 1e-14, force * (1.0 - decay**2)])
    q[0, 0] += (K / T * dt * est.rudder_sd) ** 2
    x = np.array([d.measured[0, 1], d.measured[0, 0], 0.0])
    p = np.diag([100.0 * s.noise.sensor_sd[1] ** 2, 100.0 * s.noise.sensor_sd[0] ** 2, force])
    e, log_s = np.zeros((d.time.size, nf)), np.zeros((d.time.size, nf))
    for k in range(d.time.size):
        for c, h in enumerate(np.eye(3)[[1, 0]]):
            if np.isfinite(d.measured[k, c]):
                variance = h @ p @ h + s.noise.sensor_sd[c] ** 2
                gain, innovation = p @ h / variance, d.measured[k, c] - h @ x
                e[k, c], log_s[k, c] = innovation / np.sqrt(variance), 0.5 * np.log(variance)
                x, p = x + gain * innovation, p - np.outer(gain, gain) * variance
        if k + 1 < d.time.size:
            slope = (d.rudder[k + 1] - d.rudder[k]) / dt
            x = (step @ np.array([*x, d.rudder[k], slope]))[:3]
            x[2] *= decay
            p = f @ p @ f.T + q
    return e, log_s


def test_a_linear_model_is_filtered_as_kalman_does(linear):
    est, s = linear
    now, (e, log_s) = est.evaluate(s), _textbook(*linear)
    assert now.e[:, :2] == pytest.approx(e, rel=1e-4, abs=1e-4)
    assert now.log_s[:, :2] == pytest.approx(log_s, rel=1e-6, abs=1e-6)
    assert now.log_likelihood == pytest.approx(-log_s.sum() - 0.5 * np.sum(e**2), rel=1e-5)
    assert not now.e[50:60, 1].any() and not now.e[:, 2:].any()


@pytest.mark.parametrize("vessel", ["mariner", "kvlcc2-l7", "response-2"])
def test_innovations_of_the_truth_are_white(vessel, seed):
    """At the true coefficients and the sensors' own noise: unit variance, and no correlation from sample to sample."""
    model = resolve(vessel)
    case = Case(vessel, model.suite["train"][0], "low", seed=seed % 2**31)
    est = estimator(model, [generate(case)]).with_corners(0.0)
    s = est.start()
    sd = np.array([NOISE["low"][name] for name in ("heading", "yaw_rate", "surge", "sway", "north", "east")])
    e = est.evaluate(replace(s, noise=replace(s.noise, sensor_sd=sd))).e[20:, est.channels]
    n = len(e)
    assert np.abs(np.mean(e**2, axis=0) - 1.0).max() < 4.5 * np.sqrt(2.0 / n)
    assert np.abs(np.mean(e, axis=0)).max() < 4.5 / np.sqrt(n)
    assert np.abs(np.mean(e[1:] * e[:-1], axis=0)).max() < 4.5 / np.sqrt(n)


@pytest.mark.parametrize("vessel", ["mariner", "response-1"])
def test_a_free_run_is_a_simulation_from_the_filtered_state(vessel):
    model = resolve(vessel)
    record = generate(Case(vessel, model.suite["train"][0], "low", seed=3, duration_s=200.0))
    est, free = estimator(model, [record]), 60
    s = est.start()
    first = est.evaluate(s).states[free - 1, : len(model.states)]
    inputs = inputs_of(model, est.segments[0].rudder)[free - 1 :]
    run = simulate(model, inputs, record.dt, first)
    found = est.free_run(s, 0, free)
    for c, symbol in enumerate(("psi", "r", "u", "v", "x", "y")):
        if symbol in model.states:
            wanted = run[1:, model.states.index(symbol)]
            assert found[free:, c] == pytest.approx(wanted, rel=1e-4, abs=1e-4 * np.abs(wanted).max())


def test_late_channels_have_no_jump_at_zero():
    """What the channels of a sample tell one after the other moves a late channel as it moves a present one."""
    model = resolve("mariner")
    est = estimator(model, [generate(Case("mariner", "zigzag:20/20", "low", seed=4, duration_s=200.0))])
    s = est.start()
    late_setting = est.with_entries(s, {f"{name}_delay": 1e-9 for name in SENSORS})
    now, late = est.evaluate(s), est.evaluate(late_setting)
    assert late.e == pytest.approx(now.e, abs=1e-5)
