"""Compiled free runs of learnt functions against the same runs step by step in Python."""

from dataclasses import replace

import numpy as np
import pytest

from helmbench.datasets.generator import Case, generate
from helmbench.estimation.methods_only.black_box.rows import outputs_of
from helmbench.estimation.records.series import MEASURED, series_of
from helmbench.methods.registry import make
from helmbench.models.model import resolve

SMALL = {
    "arx": "stride=3,output_lags=2,input_lags=2,alpha=1e-6",
    "narx-poly": "stride=2,output_lags=1,input_lags=1,degree=2,alpha=1e-4",
    "kernel-ridge": "stride=4,input_lags=1,alpha=1e-2,gamma=0.1",
    "gradient-boosting": "stride=4,input_lags=1",
    "mlp": "stride=4,input_lags=1,units=6,alpha=0.1",
    "grey-residual": "physics=ls,stride=2,alpha=1e-2,share=0.5",
    "grey-gp": "physics=ls,stride=4,share=1.0",
}


@pytest.mark.parametrize("ship", ["patrol", "mariner"])
@pytest.mark.parametrize("method", SMALL)
def test_compiled_runs_are_those_step_by_step(method, ship, rng):
    model = resolve(ship)
    seed = int(rng.integers(2**31))
    train = generate(Case(ship, "zigzag:20/20", duration_s=200, noise="low", seed=seed))
    predictor = make(f"{method},{SMALL[method]},trials=0").fit(train, model).predictor
    assert predictor.learnt.fast is not None
    series = series_of(
        generate(Case(ship, "zigzag:10/10", duration_s=150)).turned(model.positive_rudder), model, MEASURED
    )
    slow = replace(predictor, learnt=replace(predictor.learnt, fast=None))
    runs = [one.simulate(series.inputs, series.dt, series.start) for one in (predictor, slow)]
    known = np.isfinite(runs[0]).all(axis=1) & np.isfinite(runs[1]).all(axis=1)
    assert known.sum() > 50
    scale = np.abs(runs[1][known]).max(axis=0) + 1e-9
    np.testing.assert_allclose(runs[0][known] / scale, runs[1][known] / scale, rtol=0.0, atol=1e-6)


@pytest.mark.parametrize("method", ["arx", "grey-residual"])
def test_runs_from_far_away_are_nan_after_the_first_sample(method):
    model = resolve("patrol")
    train = generate(Case("patrol", "zigzag:20/20", duration_s=200))
    predictor = make(f"{method},{SMALL[method]},trials=0").fit(train, model).predictor
    start = np.zeros(len(model.states))
    start[model.states.index("r")] = 1e6
    run = predictor.simulate(np.zeros((20, len(model.inputs))), train.dt, start)
    assert np.isfinite(run[0]).all() and np.isnan(run[-1]).all()


@pytest.mark.parametrize("fast", [True, False])
def test_hybrid_runs_that_diverge_end_near_the_training_rows(fast):
    model = resolve("mariner")
    train = generate(Case("mariner", "zigzag:20/20", duration_s=200, noise="low", seed=1))
    predictor = make(f"grey-gp,{SMALL['grey-gp']},trials=0").fit(train, model).predictor
    series = series_of(train.turned(model.positive_rudder), model, MEASURED)
    unstable = replace(
        predictor,
        model=predictor.model.with_coefficients(-model.coefficients),
        learnt=predictor.learnt if fast else replace(predictor.learnt, fast=None),
    )
    run = unstable.simulate(series.inputs, series.dt, series.start)
    known = np.isfinite(run).all(axis=1)
    columns = [model.states.index(name) for name in outputs_of(model)]
    assert 1 < known.sum() < len(run)
    assert predictor.learnt.near(np.hstack([run[known][:, columns], series.inputs[known]])).all()
