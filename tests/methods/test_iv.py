"""iv: instruments remove the bias that noise in the regressors gives least squares."""

import numpy as np
import pytest

from helmbench.datasets.generator import Case, generate
from helmbench.methods.registry import make
from helmbench.models.model import resolve


def worst(estimate, model):
    return max(abs(estimate.parameters[name] / value - 1.0) for name, value in model.parameters.items())


@pytest.mark.parametrize("name", ["response-1", "response-2", "cargo", "remus-kt"])
def test_noise_free_records(name):
    records = [generate(Case(name, "zigzag:20/20"))]
    found = make("iv").fit(records, resolve(name))
    assert found.converged and worst(found, resolve(name)) < 1e-3


@pytest.mark.nightly
def test_bias_is_gone(rng):
    """Second-order vessel, low noise: the median of 100 draws is far nearer to the truth than by least squares."""
    model = resolve("cargo")
    records = [generate(Case("cargo", "zigzag:20/20", "low", seed=int(s))) for s in rng.integers(2**31, size=100)]
    biases = {}
    for text in ("ls,scheme=triple-integral", "iv"):
        found = [make(text).fit([record], model) for record in records]
        biases[text] = np.abs(np.median([f.coefficients for f in found], axis=0) / model.coefficients - 1.0).max()
    assert biases["iv"] < 0.4 * biases["ls,scheme=triple-integral"]


def test_lagged_instruments_beat_least_squares_on_differences(rng):
    """White noise on the yaw rate alone: instruments 4 samples late do not share it."""
    model, plain, lagged = resolve("response-1"), [], []
    clean = generate(Case("response-1", "zigzag:20/20")).with_channels(heading_rad=None)
    for _ in range(8):
        rate = clean.column("yaw_rate_rad_s")
        record = clean.with_channels(yaw_rate_rad_s=rate + rng.normal(0.0, 0.1 * rate.std(), rate.size))
        plain.append(make("ls-forward").fit([record], model).coefficients)
        lagged.append(make("iv,instruments=lagged,scheme=forward").fit([record], model).coefficients)
    bias = [abs(np.mean(found, axis=0)[0] / model.coefficients[0] - 1.0) for found in (lagged, plain)]
    assert bias[0] < 0.5 * bias[1]
