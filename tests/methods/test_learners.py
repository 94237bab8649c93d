"""Learnt predictors: chosen by free runs, better than the floor, and what they do where nothing can be learnt."""

import numpy as np
import pytest

from helmbench.estimation.run.prediction import prediction_scores
from helmbench.methods import contract
from helmbench.methods.base import KINDS
from helmbench.methods.learner import Learner
from helmbench.methods.registry import make, methods

LEARNERS = sorted(name for name, cls in methods().items() if issubclass(cls, Learner))


def scores(text, vessel="kvlcc2-l7", samples=None):
    model, records = contract.sample(vessel)
    records = [record.slice(0, samples or record.n) for record in records]
    estimate = make(text).fit(records, model)
    return prediction_scores(estimate.model, records, estimate.predictor), estimate


def test_every_kind_has_methods():
    found = {cls.kind for cls in methods().values()}
    assert found <= set(KINDS) and {"floor", "black box", "grey box"} <= found
    assert make("sklearn:Ridge").kind == make("tuned:sklearn:Ridge").kind == "black box"


@pytest.mark.parametrize("name", LEARNERS)
def test_learners_follow_their_records_better_than_the_floors(name):
    learnt, estimate = scores(name)
    assert set(estimate.extra["options"]) == set(methods()[name].search_space)
    for floor in ("mean", "straight-line"):
        assert learnt["rmse_free_yaw_rate_rad_s"] < scores(floor)[0]["rmse_free_yaw_rate_rad_s"]


def test_floors_are_what_they_say():
    model, records = contract.sample("kvlcc2-l7")
    record = records[0].turned(model.positive_rudder)
    mean = make("mean").fit(records[0], model).simulate(record)
    assert mean.column("surge_m_s")[5] == pytest.approx(record.column("surge_m_s").mean())
    straight = make("straight-line").fit(records[0], model).simulate(record)
    assert np.all(straight.column("yaw_rate_rad_s")[1:] == 0.0)
    surge = straight.column("surge_m_s")
    assert np.all(surge == surge[0]) and surge[0] == pytest.approx(record.column("surge_m_s")[0], abs=0.01)


def test_options_that_are_given_are_not_searched():
    _, estimate = scores("arx,stride=3,alpha=1e-6,trials=2")
    assert set(estimate.extra["options"]) == {"output_lags", "input_lags"} and estimate.predictor.lags.stride == 3
    _, fixed = scores("arx,stride=3,alpha=1e-6,output_lags=2,input_lags=2")
    assert "options" not in fixed.extra and fixed.predictor.lags.outputs == 2


def test_where_no_trial_can_be_judged_usual_options_are_taken_and_told():
    model, records = contract.sample("response-1")
    short = make("arx,stride=1").fit([records[0].slice(0, 12)], model)  # 60 % of it are no record
    assert "options not chosen" in short.message and not short.converged


def test_lightgbm_is_a_regressor_by_its_dotted_path():
    found, estimate = scores("sklearn:lightgbm.LGBMRegressor,n_estimators=5,n_jobs=1", samples=40)
    assert estimate.predictor is not None and np.isfinite(found["rmse_one_yaw_rate_rad_s"])
