"""Robust losses: no loss without outliers, better estimates with them, and right standard errors."""

import numpy as np
import pytest

from helmbench.datasets.generator import Case, generate
from helmbench.estimation.likelihood.loss import Loss
from helmbench.methods.output_error import OutputError
from helmbench.models.model import resolve

OUTLIERS = "yaw_rate=0.05deg_s,heading=0.1deg,yaw_rate.outliers=5%,heading.outliers=5%"
LOSSES = (Loss("huber", 1.345), Loss("student", 4.0))


@pytest.mark.parametrize("loss", LOSSES, ids=lambda loss: loss.kind)
def test_weight_and_curvature_are_derivatives(loss, rng):
    u = rng.uniform(-5.0, 5.0, 200)
    u = u[np.abs(np.abs(u) - loss.tuning) > 1e-3]
    h = 1e-5
    assert (loss.rho(u + h) - loss.rho(u - h)) / (2 * h) == pytest.approx(loss.weight(u) * u, abs=1e-8)
    slope = (loss.weight(u + h) * (u + h) - loss.weight(u - h) * (u - h)) / (2 * h)
    assert slope == pytest.approx(loss.curvature(u), abs=1e-6)


@pytest.mark.parametrize("loss", LOSSES, ids=lambda loss: loss.kind)
def test_the_scale_minimises_the_cost(loss, rng):
    errors = 3.0 * rng.standard_t(4.0, 4000)
    s = loss.scale(errors, 1e-12)
    costs = [errors.size * loss.consistency * np.log(t) + loss.rho(errors / t).sum() for t in (0.98 * s, s, 1.02 * s)]
    assert costs[1] < min(costs[0], costs[2])
    if loss.kind == "student":
        assert s == pytest.approx(3.0, rel=0.1)


def test_hubers_scale_is_the_standard_deviation_of_gaussian_noise(rng):
    assert LOSSES[0].scale(2.0 * rng.normal(size=20000), 1e-12) == pytest.approx(2.0, rel=0.05)


@pytest.mark.parametrize("loss", ["huber", "student"])
def test_outliers_have_less_effect(loss, seed):
    """5 % outliers of 10 to 20 standard deviations, 8 records: errors are smaller, and within the stated ones."""
    model = resolve("remus-kt")
    plain, robust = [], []
    for k in range(8):
        record = generate(Case("remus-kt", "zigzag:20/20", OUTLIERS, seed=seed + k))
        for errors, method in ((plain, OutputError()), (robust, OutputError(loss=loss))):
            found = method.fit([record], model)
            errors.append([(found.parameters[k] - v) / found.stderr[k] for k, v in model.parameters.items()])
            errors[-1].append(np.log(found.stderr["T1"]))
    gain = np.mean(plain, axis=0)[-1] - np.mean(robust, axis=0)[-1]
    z = np.sqrt(np.mean(np.square(np.array(robust)[:, :-1]), axis=0))
    print(np.exp(gain), z)
    assert np.exp(gain) > 1.5 and np.all(z < 2.2)


@pytest.mark.parametrize("loss", ["huber", "student"])
def test_little_is_lost_without_outliers(suite, loss):
    model, records = suite("remus-kt", noise="medium")
    plain, robust = OutputError().fit(records, model), OutputError(loss=loss).fit(records, model)
    for name, error in plain.stderr.items():
        assert 0.95 < robust.stderr[name] / error < 1.2
        assert abs(robust.parameters[name] - plain.parameters[name]) < error
