"""The unscented filter of one record against the extended one and against sampling."""

from dataclasses import replace

import numpy as np
import pytest

from helmbench.datasets.generator import Case, generate
from helmbench.estimation.records.series import series_of
from helmbench.methods import kalman as joint
from helmbench.models.model import resolve
from helmbench.models.simulate import simulate


def setting(ship, text, seed=1, noise="low"):
    model = resolve(ship)
    series = series_of(generate(Case(ship, text, noise, seed=seed)), model)
    sensor, change = joint.sensor_variances([series], len(model.states)), joint.square_changes(model, [series])
    return model, series, joint.NoiseVariances(1e-6, 1e-6 * change, sensor)


@pytest.mark.parametrize("alpha", [0.01, 0.1, 1.0])
def test_with_fixed_coefficients_of_a_linear_model_it_is_the_kalman_filter(alpha):
    """Sigma points carry a Gaussian through a linear map exactly, at any distance."""
    model, series, noise = setting("cargo", "zigzag:20/20")
    fixed = joint.CoefficientDensity.fixed(model.coefficients)
    found = joint.filter_record(model, series, fixed, noise, (alpha, 2.0))
    exact = joint.filter_record(model, series, fixed, noise)
    assert found.cost == pytest.approx(exact.cost, rel=1e-7)
    assert found.innovations == pytest.approx(exact.innovations, rel=1e-6, abs=1e-9)


def test_with_a_narrow_prior_it_is_the_extended_filter():
    """With a small uncertainty of the coefficients only the linear term matters."""
    model, series, noise = setting("response-1", "zigzag:20/20")
    factor = np.diag(1e-5 * np.abs(model.coefficients))
    prior = joint.CoefficientDensity.prior(1.00001 * model.coefficients, factor)
    found = joint.filter_record(model, series, prior, noise, (0.1, 2.0))
    after, path = found.density, found.path
    extended = joint.filter_record(model, series, prior, noise)
    step = np.abs(extended.density.mean).max()
    assert after.mean == pytest.approx(extended.density.mean, abs=1e-3 * max(step, 1e-3))
    assert path[-1] == pytest.approx(after.coefficients, rel=1e-12)


def test_one_measurement_gives_the_posterior_of_sampling(rng):
    """A wide prior of the coefficients, one exact yaw rate a step later: the posterior of linear regression."""
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
    noise = joint.NoiseVariances(0.0, np.zeros(2), sensor)
    prior = joint.CoefficientDensity.prior(model.coefficients, factor)
    after = joint.filter_record(model, series, prior, noise, (0.5, 2.0)).density
    gain = draws.T @ (runs - np.mean(runs)) / len(runs) / (np.var(runs) + sensor[0])
    expected = gain * (series.outputs[1, 0] - np.mean(runs))
    print(after.mean, expected)
    assert after.mean == pytest.approx(expected, abs=0.1 * np.abs(expected).max() + 1e-3)
    assert np.trace(after.covariance) == pytest.approx(2.0, abs=0.05)  # one direction of three is known now
