"""The robust methods: efficiency without outliers, and the outlier figures of paper 003."""

import numpy as np
import pytest

from helmbench.datasets.generator import Case, generate
from helmbench.datasets.record import Record
from helmbench.estimation.methods_only.regression.weighted import RegressionRows
from helmbench.estimation.regression.samples import RegressionSamples
from helmbench.methods.registry import make
from helmbench.models.model import resolve
from helmbench.models.simulate import regression

from ..nightly_marks import nightly_but

ROBUST = ("huber", "tukey", "lts")


def cargo_rows(rng, n, outliers, burst, noise=0.05):
    """Rows of the cargo vessel in three sines every 2 s, noise on psi_dddot, outliers of 10-20 sigma of either sign.

    Bursts are runs of 30 samples of one sign.  The case of paper 003's page: least squares there is 2.4 % off with
    independent outliers and 5.5 % with bursts (medians of 300 draws here: 2.4 and 6.4 %).
    """
    model = resolve("cargo")
    record = generate(Case("cargo", model.suite["train"][0], duration_s=2.0 * n, dt_s=2.0))
    r, delta = record.column("yaw_rate_rad_s"), record.rudder()
    q, moved = np.gradient(r, 2.0), np.gradient(delta, 2.0)
    states, inputs = np.column_stack([q, r, np.zeros_like(r)]), np.column_stack([delta, moved])
    y = regression(model, states, np.zeros((len(r), 1)), inputs)[1][:, 0] @ model.coefficients
    sigma = noise * np.std(y)
    errors = rng.normal(0.0, sigma, len(y))
    length = 30 if burst else 1
    runs = len(y) // length
    signs = rng.permutation(runs) < round(outliers * runs)
    signs = np.resize(np.repeat(signs * rng.choice([-1.0, 1.0], runs), length), len(y))
    errors += signs * rng.uniform(10.0, 20.0, len(y)) * sigma
    return model, RegressionSamples(states, (y + errors)[:, None], inputs, record.time_s)


def fitted(name, model, rows, monkeypatch):
    """Worst relative parameter error of a method on given rows."""
    monkeypatch.setattr("helmbench.methods.base.regression_samples", lambda *_: [rows])
    records = [Record(rows.time_s, {"rudder_rad": rows.inputs[:, 0]})]
    found = make(name).fit(records, model)
    return max(abs(found.parameters[k] / v - 1.0) for k, v in model.parameters.items())


@pytest.mark.parametrize("name", nightly_but(ROBUST, "huber", "tukey"))
@pytest.mark.parametrize("burst", nightly_but([False, True], True), ids=["scattered", "burst"])
def test_ten_percent_outliers(name, burst, rng, monkeypatch):
    """Below 1 % where least squares is several times worse, and nearly as without outliers; medians over 40 draws.

    Huber's influence does not redescend: outliers keep some influence, about 1 % in bursts (.95, 300 draws).
    """
    worst = []
    for _ in range(40):
        seed = int(rng.integers(2**31))
        model, clean = cargo_rows(np.random.default_rng(seed), 3000, 0.0, burst)
        _, rows = cargo_rows(np.random.default_rng(seed), 3000, 0.1, burst)
        plain = RegressionRows([rows], model.blanked()).start.coefficients
        least = max(
            abs(v / model.parameters[k] - 1.0)
            for k, v in zip(model.parameters, model.to_parameters(plain), strict=True)
        )
        worst.append((fitted(name, model, rows, monkeypatch), least, fitted(name, model, clean, monkeypatch)))
    robust, least, alone = np.median(worst, axis=0)
    print(robust, least, alone)
    assert robust < 0.5 * least
    if name != "huber":
        assert robust < 0.01 and robust < 2.2 * alone


@pytest.mark.parametrize("name", ROBUST)
def test_efficiency_and_standard_errors(name, rng, monkeypatch):
    """On Gaussian noise about 95 % as good as least squares, and the stated errors are the actual ones."""
    model, rows = cargo_rows(rng, 800, 0.0, False, noise=0.0)
    sigma, exact = 1e-7, rows.accelerations
    plain, robust, stated = [], [], []
    monkeypatch.setattr("helmbench.methods.base.regression_samples", lambda *_: [noisy])
    for _ in range(60):
        noisy = RegressionSamples(rows.states, exact + rng.normal(0.0, sigma, exact.shape), rows.inputs, rows.time_s)
        found = make(name, **({"starts": 2} if name == "lts" else {})).fit(
            [Record(rows.time_s, {"rudder_rad": rows.inputs[:, 0]})], model
        )
        plain.append(RegressionRows([noisy], model.blanked()).start.coefficients)
        robust.append(found.coefficients)
        stated.append(np.sqrt(np.diag(found.covariance)))
    loss = np.std(robust, axis=0) / np.std(plain, axis=0)
    assert loss.min() > 0.9 and loss.max() < 1.35
    assert np.median(stated, axis=0) / np.std(robust, axis=0) == pytest.approx(np.ones(4), abs=0.45)


def test_lts_draws_from_its_seed():
    records = [generate(Case("response-1", "zigzag:20/20", "medium", seed=4))]
    first, again = (make("lts,seed=5").fit(records, resolve("response-1")) for _ in range(2))
    assert np.array_equal(first.coefficients, again.coefficients)
