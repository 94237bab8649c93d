"""Ensembles of free runs, drawn from what an estimate says of its own uncertainty."""

import dataclasses

import numpy as np
import pytest

from helmbench.datasets.generator import Case, generate
from helmbench.estimation.judgement.ensemble import COUNT, ensemble_scores, members, spread_scores
from helmbench.estimation.methods_only.black_box.compiled import drawn
from helmbench.estimation.methods_only.black_box.limited import gaussian_process
from helmbench.estimation.run.prediction import prediction_scores
from helmbench.methods.registry import make
from helmbench.models.model import resolve


@pytest.fixture(scope="module")
def records():
    pairs = (("10/10", 1), ("20/20:port", 2))
    return [generate(Case("response-1", f"zigzag:{text}", "low", seed=number)) for text, number in pairs]


@pytest.fixture(scope="module")
def held_out():
    return [generate(Case("response-1", "zigzag:15/15", "none"))]


GP = "gp-narx,stride=16,input_lags=1"


def fitted(text, records):
    return make(text).fit(records, resolve("response-1").blanked())


def test_the_score_is_that_of_its_definition(seed):
    rng = np.random.default_rng(seed)
    free, observed = rng.normal(size=(7, 40)), rng.normal(size=40)
    apart = [np.abs(a - b) for i, a in enumerate(free) for j, b in enumerate(free) if i != j]
    expected = np.abs(free - observed).mean() - 0.5 * np.mean(apart)
    assert spread_scores(free, observed)[0] == pytest.approx(expected, rel=1e-12)
    same = np.tile(rng.normal(size=40), (5, 1))
    assert spread_scores(same, observed) == (pytest.approx(np.abs(same[0] - observed).mean()), 0.0)


def test_a_spread_that_tells_the_errors_covers_them(seed):
    """Of 20 members and a sample from one normal density, 93 % lie inside: Student's t with 19 degrees of freedom."""
    rng = np.random.default_rng(seed)
    rows = rng.normal(size=(COUNT + 1, 40_000))
    inside = spread_scores(rows[1:], rows[0])[1]
    assert inside == pytest.approx(0.9277, abs=5.0 * np.sqrt(0.93 * 0.07 / 40_000) + 1e-3)


def test_drawn_coefficients_have_the_covariance_of_the_estimate(records, seed):
    estimate = fitted("output-error", records)
    draws = np.array([one.model.coefficients for one in members(estimate, 4000, np.random.default_rng(seed))])
    sd = np.sqrt(np.diag(estimate.covariance))
    assert np.all(np.abs(draws.mean(axis=0) - estimate.coefficients) < 6.0 * sd / np.sqrt(4000))
    ratio = np.cov(((draws - estimate.coefficients) / sd).T)
    assert np.abs(ratio - estimate.covariance / np.outer(sd, sd)).max() < 0.15


def test_draws_of_a_gaussian_process_have_its_mean_and_variance(seed):
    """Also at points between and near the rows, where scikit-learn gives both in closed form."""
    rng = np.random.default_rng(seed)
    x = rng.normal(size=(80, 2))
    y = np.sin(2.0 * x[:, :1]) + x[:, 1:] + 0.3 * rng.normal(size=(80, 1))
    process = gaussian_process(2).fit(x, y.ravel())
    count, at = 3000, x[:20] + 0.05 * rng.normal(size=(20, 2))
    found = np.array([one(at)[:, 0] for one in drawn([process], 1, count, rng)])
    mean, noisy = process.predict(at, return_std=True)
    sd = np.sqrt(noisy**2 - process.kernel_.k2.noise_level)
    assert np.all(np.abs(found.mean(axis=0) - mean) < 6.0 * sd / np.sqrt(count) + 1e-3)
    assert np.all(np.abs(found.std(axis=0) / sd - 1.0) < 0.12)


def test_draws_of_a_forest_are_its_trees(records, seed):
    learnt = fitted("random-forest,stride=4,input_lags=1,min_samples_leaf=3", records).predictor.learnt
    x = np.random.default_rng(seed).normal(size=(50, learnt.mean.size))
    trees = drawn(learnt.regressors, 1, 1000, np.random.default_rng(seed))
    assert len(trees) == len(learnt.regressors[0].estimators_)
    assert np.mean([tree(x) for tree in trees], axis=0) == pytest.approx(learnt.fast(x), abs=1e-9)


@pytest.mark.parametrize("text", ["pem", GP, "random-forest,stride=16,trials=0", "grey-gp,trials=0,share=1"])
def test_an_ensemble_follows_the_record(text, records, held_out):
    """The score of the spread is below the mean absolute error of a ship that keeps the record's mean."""
    found = ensemble_scores(fitted(text, records), held_out, 0)
    assert 0.0 < found["crps"] < 0.5 and 0.0 < found["coverage"] <= 1.0


def test_smaller_stated_errors_cover_less(records, held_out):
    estimate = fitted("ls", records)
    sure = dataclasses.replace(estimate, covariance=estimate.covariance / 1e4)
    wide, narrow = (ensemble_scores(one, held_out, 0) for one in (estimate, sure))
    assert narrow["coverage"] < 0.5 * wide["coverage"]


def test_a_hybrid_draws_its_physics_too(records):
    hybrid = fitted("grey-residual,trials=0", records)
    runs = members(hybrid, 5, np.random.default_rng(0))
    assert len({one.model.coefficients.tobytes() for one in runs}) == 5


@pytest.mark.parametrize("text", ["arx,trials=0", "mean"])
def test_without_a_stated_uncertainty_there_is_no_score(text, records, held_out):
    assert ensemble_scores(fitted(text, records), held_out, 0) == {}


def test_an_infinite_variance_gives_no_ensemble(records, held_out):
    estimate = fitted("ls", records)
    unknown = estimate.covariance.copy()
    unknown[0, 0] = np.inf
    assert ensemble_scores(dataclasses.replace(estimate, covariance=unknown), held_out, 0) == {}


def test_a_member_that_diverges_makes_the_score_infinite(records, held_out):
    estimate = fitted("ls", records)
    wild = dataclasses.replace(estimate, covariance=1e12 * np.eye(len(estimate.coefficients)))
    assert ensemble_scores(wild, held_out, 0) == {"crps": np.inf}


def test_the_ensemble_of_exact_coefficients_has_the_error_of_the_free_run(records, held_out):
    """Without spread the score is the mean absolute error: below the root mean square error."""
    estimate = fitted("ls", records)
    exact = dataclasses.replace(estimate, covariance=np.zeros_like(estimate.covariance))
    found, errors = ensemble_scores(exact, held_out, 0), prediction_scores(estimate.model, held_out)
    channels = ("heading_rad", "yaw_rate_rad_s")
    rms = np.mean([np.sqrt(1.0 - errors[f"r2_free_{channel}"]) for channel in channels])
    assert 0.3 * rms < found["crps"] <= rms and found["coverage"] < 0.05
