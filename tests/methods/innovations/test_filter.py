"""The innovations filter against a textbook Kalman filter, plain NumPy and the simulator."""

import numpy as np
import pytest
from scipy.linalg import expm

from helmbench.datasets.generator import Case, generate
from helmbench.datasets.record import Record
from helmbench.datasets.sensors import NOISE
from helmbench.methods.innovations import _filter
from helmbench.methods.innovations.estimator import Estimator, Setting
from helmbench.methods.innovations.layout import PLACE
from helmbench.models import drivers
from helmbench.models.model import resolve
from helmbench.models.simulate import initial_state, inputs_of, simulate

SDS = {"heading_rad": np.deg2rad(0.02), "yaw_rate_rad_s": np.deg2rad(0.01)}
T, K = 12.0, 0.08


@pytest.fixture
def linear(rng):
    """First-order Nomoto model and a noisy record of it with gaps, under gusts that the filter is told of."""
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
    est = Estimator(model, [record])
    s = est.start()
    noise = s.noise.copy()
    noise[0], noise[1] = SDS["heading_rad"], SDS["yaw_rate_rad_s"]
    noise[6], noise[7] = 3e-4 / est.unit[0], 7.0
    return est.with_corners(0.0), Setting(s.p, noise)


def _textbook(est, s):
    """Kalman filter of (r, psi, force): innovations and log S / 2 of heading and rate, measured one after the other."""
    d, dt, nf = est.data[0], est.data[0].time[1], 2
    a = np.array([[-1.0 / T, 0.0, 1.0], [1.0, 0.0, 0.0], [0.0, 0.0, 0.0]])
    whole = np.zeros((5, 5))
    whole[:3, :3], whole[0, 3], whole[3, 4] = a, K / T, 1.0
    step = expm(whole * dt)
    decay, force = np.exp(-dt / s.noise[7]), (s.noise[6] * est.unit[0]) ** 2
    f = step[:3, :3].copy()
    f[2, 2] = decay
    q = np.diag([1e-14, 1e-14, force * (1.0 - decay**2)])
    q[0, 0] += (K / T * dt * est.rudder_sd) ** 2
    x = np.array([d.measured[0, 1], d.measured[0, 0], 0.0])
    p = np.diag([100.0 * s.noise[1] ** 2, 100.0 * s.noise[0] ** 2, force])
    e, log_s = np.zeros((d.time.size, nf)), np.zeros((d.time.size, nf))
    for k in range(d.time.size):
        for c, h in enumerate(np.eye(3)[[1, 0]]):
            if np.isfinite(d.measured[k, c]):
                variance = h @ p @ h + s.noise[c] ** 2
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
    est = Estimator(model, [generate(case)]).with_corners(0.0)
    s = est.start()
    noise = s.noise.copy()
    noise[:6] = [NOISE["low"][name] for name in ("heading", "yaw_rate", "surge", "sway", "north", "east")]
    e = est.evaluate(Setting(s.p, noise)).e[20:, est.channels]
    n = len(e)
    assert np.abs(np.mean(e**2, axis=0) - 1.0).max() < 4.5 * np.sqrt(2.0 / n)
    assert np.abs(np.mean(e, axis=0)).max() < 4.5 / np.sqrt(n)
    assert np.abs(np.mean(e[1:] * e[:-1], axis=0)).max() < 4.5 / np.sqrt(n)


@pytest.mark.parametrize("vessel", ["mariner", "response-1"])
def test_a_free_run_is_a_simulation_from_the_filtered_state(vessel):
    model = resolve(vessel)
    record = generate(Case(vessel, model.suite["train"][0], "low", seed=3, duration_s=200.0))
    est, free = Estimator(model, [record]), 60
    s = est.start()
    first = est.evaluate(s).states[free - 1, : len(model.states)]
    inputs = inputs_of(model, est.data[0].rudder)[free - 1 :]
    run = simulate(model, inputs, record.dt, first)
    found = est.free_run(s, 0, free)
    for c, symbol in enumerate(("psi", "r", "u", "v", "x", "y")):
        if symbol in model.states:
            wanted = run[1:, model.states.index(symbol)]
            assert found[free:, c] == pytest.approx(wanted, rel=1e-4, abs=1e-4 * np.abs(wanted).max())


# ---- the rudder that the hull feels
def _acting(time, rudder, parts=2, noise=1e-12, **values):
    q = np.zeros(len(PLACE))
    for name, value in values.items():
        q[PLACE[name]] = value
    out = np.empty((time.size - 1) * parts + 1)
    quiet = np.empty(time.size)
    drivers.quieten(rudder, noise, quiet)
    _filter.acting_rudder(time, rudder, quiet, q, noise, parts, out)
    return np.linspace(0.0, time[-1], out.size), out


@pytest.fixture
def wiggle(rng):
    time = 0.5 * np.arange(200)
    steps = rng.normal(size=time.size)
    return time, 0.05 * np.convolve(steps, np.ones(10), "same")


def test_rudder_delay_offset_and_effectiveness(wiggle):
    time, rudder = wiggle
    fine, found = _acting(time, rudder, rudder_delay=1.3, rudder_offset=0.02, rudder_effectiveness=-0.1)
    assert found == pytest.approx(0.9 * np.interp(fine - 1.3, time, rudder) + 0.02, abs=1e-12)


def test_rudder_fault_sets_in_within_a_step(wiggle):
    time, rudder = wiggle
    fine, found = _acting(time, rudder, fault=-0.4, fault_time=40.1)
    share = np.clip((fine - 40.1) / 0.5 + 0.5, 0.0, 1.0)
    assert found == pytest.approx((1.0 - 0.4 * share) * np.interp(fine, time, rudder), abs=1e-12)


def test_rudder_limits(wiggle):
    """The rate first, as the gear does, and between the samples too."""
    time, rudder = wiggle
    fine, found = _acting(time, rudder, parts=4, rudder_limit=0.12, rudder_rate=0.04)
    command = np.interp(fine, time, rudder)
    limited = [command[0]]
    for value in command[1:]:
        limited.append(limited[-1] + np.clip(value - limited[-1], -0.04 * 0.125, 0.04 * 0.125))
    assert found == pytest.approx(np.clip(limited, -0.12, 0.12), abs=1e-12)


def test_a_play_far_below_the_noise_changes_nothing(wiggle, rng):
    time, rudder = wiggle
    noisy = rudder + 0.01 * rng.normal(size=rudder.size)
    fine, found = _acting(time, noisy, noise=0.01, rudder_play=1e-7)
    assert found == pytest.approx(np.interp(fine, time, noisy), abs=1e-5)


def test_rudder_backlash(wiggle):
    """Between the samples too."""
    time, rudder = wiggle
    fine, found = _acting(time, rudder, parts=4, rudder_play=0.03)
    command = np.interp(fine, time, rudder)
    z = [command[0]]
    for value in command[1:]:
        z.append(np.clip(z[-1], value - 0.03, value + 0.03))
    assert found == pytest.approx(z, abs=1e-12)


def test_noise_on_a_held_rudder_is_no_play(rng):
    """The highest noise of a plateau would push the linkage further: as if the play were larger."""
    time = 0.5 * np.arange(4000)
    clean = np.where(np.arange(4000) // 40 % 2 == 0, 0.3, -0.3)
    _, found = _acting(time, clean + 1e-3 * rng.normal(size=4000), noise=1e-3, rudder_play=0.01)
    held = found[::2].reshape(-1, 40)[1:, 5:]
    assert np.abs(held).mean() == pytest.approx(0.29, abs=1.8e-4)


def test_late_channels_have_no_jump_at_zero():
    """What the channels of a sample tell one after the other moves a late channel as it moves a present one."""
    model = resolve("mariner")
    est = Estimator(model, [generate(Case("mariner", "zigzag:20/20", "low", seed=4, duration_s=200.0))])
    s = est.start()
    p = s.p.copy()
    p[:, [est.index[f"delay_{c}"] for c in ("psi", "r", "u", "v", "x", "y")]] = 1e-9
    now, late = est.evaluate(s), est.evaluate(Setting(p, s.noise))
    assert late.e == pytest.approx(now.e, abs=1e-5)
