"""Rows of difference equations with lags, and what is learnt from them."""

import numpy as np
import pytest

from helmbench.datasets.generator import Case, generate
from helmbench.estimation.methods_only.black_box.narx import NarxPredictor
from helmbench.estimation.methods_only.black_box.rows import BRIDGED, Lags, narx_rows, outputs_of, signals_of
from helmbench.estimation.methods_only.black_box.scaled import fit_scaled
from helmbench.estimation.methods_only.black_box.terms import (
    TermRegression,
    evaluate,
    manoeuvring_terms,
    monomials,
    sparse,
)
from helmbench.estimation.records.series import MEASURED, series_of
from helmbench.models.errors import CannotFit
from helmbench.models.model import resolve

MODEL = resolve("cargo")


def record(**changes):
    return generate(Case("cargo", "zigzag:20/20", **changes))


def test_rows_are_lagged_values_and_increments_of_averaged_signals():
    one = record()
    signals = signals_of([one], MODEL)
    lags = Lags(stride=3, outputs=2, inputs=2)
    x, y = narx_rows(signals, lags)
    r, rudder = (
        np.convolve(values, np.ones(3) / 3.0, "valid") for values in (one.column("yaw_rate_rad_s"), one.rudder())
    )
    k = 7  # a row: the averages that begin at sample 7 + 3
    np.testing.assert_allclose(x[k], [r[k + 3], r[k], rudder[k + 3], rudder[k]], rtol=1e-9, atol=1e-12)
    np.testing.assert_allclose(y[k, 0], (r[k + 6] - r[k + 3]) / (3 * one.dt), rtol=1e-9, atol=1e-12)
    assert lags.features(MODEL) == ("r", "r", "delta", "delta")


def test_rows_over_long_gaps_are_left_out_and_short_gaps_bridged():
    one = record()
    values = one.column("yaw_rate_rad_s").copy()
    values[50 : 50 + BRIDGED] = np.nan
    short = one.with_channels(yaw_rate_rad_s=values)
    assert len(narx_rows(signals_of([short], MODEL), Lags())[0]) == one.n - 1
    values = values.copy()
    values[100 : 101 + BRIDGED] = np.nan
    long = one.with_channels(yaw_rate_rad_s=values)
    assert len(narx_rows(signals_of([long], MODEL), Lags())[0]) == one.n - 1 - (BRIDGED + 2)


def test_too_few_rows_are_refused():
    with pytest.raises(CannotFit, match="usable rows"):
        narx_rows(signals_of([record().slice(0, 20)], MODEL), Lags(stride=16, outputs=3, inputs=3))


def learnt(rows, make, lags, dt):
    function = fit_scaled(*rows, make, lags.features(MODEL))
    return NarxPredictor(tuple(MODEL.states), outputs_of(MODEL), lags.stride * dt, lags, function)


@pytest.mark.parametrize("stride", [1, 3])
def test_a_linear_ship_is_learnt_exactly_enough_at_any_sampling(stride):
    signals = signals_of([record()], MODEL)
    lags = Lags(stride, 2, 2)
    rows = narx_rows(signals, lags)
    predictor = learnt(rows, lambda d: TermRegression(monomials(d, 1), alpha=1e-7), lags, signals[0].dt)
    for dt in (1.0, 0.5):
        held_out = record(dt_s=dt, seed=4).turned(MODEL.positive_rudder)
        series = series_of(held_out, MODEL, MEASURED)
        run = predictor.simulate(series.inputs, series.dt, series.start)
        place = MODEL.states.index("r")
        truth = held_out.column("yaw_rate_rad_s")
        assert np.abs(run[:, place] - truth).max() < 0.05 * np.abs(truth).max()


def test_a_run_far_from_the_training_records_ends_in_nan():
    signals = signals_of([record()], MODEL)
    lags = Lags(2, 1, 1)
    x, y = narx_rows(signals, lags)
    predictor = learnt((x, -5.0 * y), lambda d: TermRegression(monomials(d, 3)), lags, signals[0].dt)
    run = predictor.simulate(1e5 + np.zeros((50, 1)), 1.0, np.zeros(len(MODEL.states)))
    assert np.isfinite(run[0]).all() and np.isnan(run[-1]).all()


def test_terms_are_products_and_absolute_values(rng):
    x = rng.normal(size=(40, 2))
    factors = manoeuvring_terms([True, False])
    found = {tuple(np.round(column, 12)) for column in evaluate(factors, x).T}
    for wanted in (x[:, 0] ** 2 * x[:, 1], np.ones(40), np.abs(x[:, 0]) * x[:, 1]):
        assert tuple(np.round(wanted, 12)) in found
    assert tuple(np.round(np.abs(x[:, 1]) * x[:, 0], 12)) not in found
    assert len(monomials(4, 2)) == 15


def test_sparse_regression_agrees_with_pysindy(rng):
    from pysindy import STLSQ

    theta = rng.normal(size=(400, 9))
    theta /= np.sqrt(np.mean(theta**2, axis=0))
    wanted = np.array([1.0, 0.0, 0.5, 0.0, 0.0, -0.3, 0.02, 0.0, 0.0])
    target = theta @ wanted + 0.01 * rng.normal(size=400)
    target /= np.sqrt(np.mean(target**2))
    other = STLSQ(threshold=0.1, alpha=1e-6 * len(theta)).fit(theta, target[:, None])
    own = sparse(theta, target[:, None], 1e-6, 0.1)
    np.testing.assert_allclose(own.T, other.coef_, rtol=1e-3, atol=1e-9)
    assert np.flatnonzero(own[:, 0]).tolist() == [0, 2, 5]
