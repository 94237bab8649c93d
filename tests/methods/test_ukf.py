"""Unscented Kalman filter against the extended one, sampling, and held-out records."""

from dataclasses import replace

import numpy as np
import pytest

from helmbench.datasets.generator import Case, generate
from helmbench.methods import ekf
from helmbench.methods.series import series_of
from helmbench.methods.ukf import Ukf, unscented_run
from helmbench.models.errors import BadInput
from helmbench.models.model import resolve
from helmbench.models.simulate import simulate


def setting(ship, text, seed=1, noise="low"):
    model = resolve(ship)
    series = series_of(generate(Case(ship, text, noise, seed=seed)), model)
    sensor, change = ekf.sensor_variances([series], len(model.states)), ekf.changes(model, [series])
    return model, series, ekf.Noise(1e-6, 1e-6 * change, sensor)


@pytest.mark.parametrize("alpha", [0.01, 0.1, 1.0])
def test_with_held_coefficients_of_a_linear_model_it_is_the_kalman_filter(alpha):
    """Sigma points carry a Gaussian through a linear map exactly, at any distance."""
    model, series, noise = setting("cargo", "zigzag:20/20")
    held = ekf.Belief.certain(model.coefficients)
    _, _, innovations, cost = unscented_run(model, series, held, noise, alpha, 2.0)
    exact = ekf.run_filter(model, series, held, noise)
    assert cost == pytest.approx(exact.cost, rel=1e-7)
    assert innovations == pytest.approx(exact.innovations, rel=1e-6, abs=1e-9)


def test_a_narrow_belief_makes_it_the_extended_filter():
    """With small uncertainty of the coefficients the tangent is all there is."""
    model, series, noise = setting("response-1", "zigzag:20/20")
    factor = np.diag(1e-5 * np.abs(model.coefficients))
    belief = ekf.Belief.prior(1.00001 * model.coefficients, factor)
    after, path, _, _ = unscented_run(model, series, belief, noise, 0.1, 2.0)
    extended = ekf.run_filter(model, series, belief, noise)
    step = np.abs(extended.belief.mean).max()
    assert after.mean == pytest.approx(extended.belief.mean, abs=1e-3 * max(step, 1e-3))
    assert path[-1] == pytest.approx(after.coefficients, rel=1e-12)


def test_one_measurement_teaches_what_sampling_says(rng):
    """A wide belief about the coefficients, one exact yaw rate a step later: the posterior of linear regression."""
    model = resolve("response-1")
    record = generate(Case("response-1", "zigzag:20/20", "low", seed=1)).slice(60, 62).with_channels(heading_rad=None)
    series = series_of(record, model)
    series = replace(series, start_sd=np.zeros(2))
    factor = np.diag(0.3 * np.abs(model.coefficients))
    draws = rng.normal(size=(4000, 3))
    runs = [
        simulate(model.with_coefficients(model.coefficients + factor @ e), series.inputs, series.dt, series.start)[
            -1, 0
        ]
        for e in draws
    ]
    sensor = np.full(2, 1e-4 * np.var(runs))
    noise = ekf.Noise(0.0, np.zeros(2), sensor)
    after = unscented_run(model, series, ekf.Belief.prior(model.coefficients, factor), noise, 0.5, 2.0)[0]
    gain = draws.T @ (runs - np.mean(runs)) / len(runs) / (np.var(runs) + sensor[0])
    expected = gain * (series.outputs[1, 0] - np.mean(runs))
    print(after.mean, expected)
    assert after.mean == pytest.approx(expected, abs=0.1 * np.abs(expected).max() + 1e-3)
    assert np.trace(after.covariance) == pytest.approx(2.0, abs=0.05)  # one direction of three is known now


def test_mariner_rich_set_predicts_held_out_zigzag():
    """Noise .01 m/s and .05 deg/s: at least as good as smoothing and least squares (.03)."""
    model = resolve("mariner-model")
    noise = "surge=0.01m_s,sway=0.01m_s,yaw_rate=0.05deg_s"
    records = [generate(Case("mariner-model", text, noise, seed=2)) for text in model.suite["train"]]
    found = Ukf(passes=2).fit(records, model).model
    held = generate(Case("mariner-model", "zigzag:30/30"))
    start = np.array([held.column("surge_m_s")[0], 0.0, 0.0, 0.0, 0.0, 0.0])
    run = simulate(found, held.rudder()[:, None], held.dt, start)
    channels = [held.column(name) for name in ("surge_m_s", "sway_m_s", "yaw_rate_rad_s")]
    error = [np.sqrt(np.mean((run[:, i] - y) ** 2)) / y.std() for i, y in enumerate(channels)]
    print(error)
    assert max(error) < 0.05


def test_response_model_from_a_noisy_heading(rng):
    """T2 and T3 all but cancel: over 110 draws T2 is off by -3 +- 4 %, T1 by -0.1 +- 0.1 %, K by +- 0.006 %."""
    model = resolve("cargo")
    record = generate(Case("cargo", model.suite["train"][0], "none", duration_s=3600.0)).with_channels(
        yaw_rate_rad_s=None
    )
    noisy = record.with_channels(heading_rad=record.column("heading_rad") + 2e-4 * rng.normal(size=record.n))
    found = Ukf(passes=10).fit([noisy], model).parameters
    print(found)
    limits = {"T1": 0.01, "T2": 0.25, "T3": 0.18, "K": 0.001}
    assert all(found[name] == pytest.approx(value, rel=limits[name]) for name, value in model.parameters.items())


@pytest.mark.parametrize("options", [{"alpha": 0.0}, {"alpha": 1.5}, {"beta": 0.0}, {"passes": 0}])
def test_impossible_options(options):
    with pytest.raises(BadInput):
        Ukf(**options).fit([generate(Case("cargo", "zigzag:20/20"))], resolve("cargo"))
