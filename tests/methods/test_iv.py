"""iv: instruments remove the bias that noise in the regressors gives least squares."""

import numpy as np
import pytest

from helmbench.datasets.generator import Case, generate
from helmbench.methods.iv import simulated
from helmbench.methods.registry import make
from helmbench.models.errors import BadInput
from helmbench.models.model import resolve


def worst(estimate, model):
    return max(abs(estimate.parameters[name] / value - 1.0) for name, value in model.parameters.items())


@pytest.mark.parametrize("name", ["response-1", "response-2", "cargo", "remus-kt"])
def test_noise_free_records(name):
    records = [generate(Case(name, "zigzag:20/20"))]
    found = make("iv").fit(records, resolve(name))
    assert found.converged and worst(found, resolve(name)) < 1e-3


def test_bias_is_gone(rng):
    """Second-order ship with low noise: the median of 25 draws is far nearer than that of least squares."""
    model = resolve("cargo")
    seeds = rng.integers(2**31, size=25)
    biases = {}
    for text in ("ls,scheme=triple-integral", "iv"):
        found = [make(text).fit([generate(Case("cargo", "zigzag:20/20", "low", seed=int(s)))], model) for s in seeds]
        biases[text] = np.abs(np.median([f.coefficients for f in found], axis=0) / model.coefficients - 1.0).max()
    assert biases["iv"] < 0.4 * biases["ls,scheme=triple-integral"]


def test_lagged_instruments_beat_least_squares_on_differences(rng):
    """White noise on the yaw rate alone: instruments 4 samples late do not share it."""
    model, plain, lagged = resolve("response-1"), [], []
    clean = generate(Case("response-1", "zigzag:20/20")).with_channels(heading_rad=None)
    for _ in range(8):
        rate = clean.column("yaw_rate_rad_s")
        record = clean.with_channels(yaw_rate_rad_s=rate + rng.normal(0.0, 0.1 * rate.std(), rate.size))
        plain.append(make("ls").fit([record], model).coefficients)
        lagged.append(make("iv,instruments=lagged,scheme=forward").fit([record], model).coefficients)
    bias = [abs(np.mean(found, axis=0)[0] / model.coefficients[0] - 1.0) for found in (lagged, plain)]
    assert bias[0] < 0.5 * bias[1]


def test_simulated_record_is_the_run_and_keeps_gaps():
    model = resolve("kvlcc2-l7")
    record = generate(Case("kvlcc2-l7", "zigzag:20/20", duration_s=60, dt_s=0.2))
    sway = record.column("sway_m_s").copy()
    sway[50:60] = np.nan
    run = simulated(record.with_channels(sway_m_s=sway), model)
    assert np.isnan(run.column("sway_m_s")[50:60]).all()
    for name in ("surge_m_s", "yaw_rate_rad_s", "heading_rad"):
        assert run.column(name) == pytest.approx(record.column(name), abs=1e-9)


def test_a_run_that_goes_astray_is_started_anew():
    """With an unstable estimate the instruments stay finite and near the record."""
    model = resolve("response-1")
    record = generate(Case("response-1", "zigzag:20/20"))
    run = simulated(record, model.with_coefficients([5.0, 5.0, 100.0]))
    assert np.isfinite(run.column("yaw_rate_rad_s")).all()
    assert np.abs(run.column("yaw_rate_rad_s")).max() < 20.0 * np.abs(record.column("yaw_rate_rad_s")).max()


@pytest.mark.parametrize(
    "text", ["iv,instruments=none", "iv,lag=0", "iv,iterations=0", "iv,horizon_s=-1", "iv,scheme=x"]
)
def test_impossible_options_are_refused(text):
    with pytest.raises(BadInput):
        make(text)
