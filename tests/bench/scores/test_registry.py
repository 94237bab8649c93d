"""Scores: found by the registry, each filling its columns."""

import types

import numpy as np
import pytest
from scipy.stats import norm

from helmbench.bench.kinds.identification.columns import result_columns
from helmbench.bench.scores import Outcome, compute, score_columns, scores


def row(estimate, true, crb_sd, identifiable=True, kind="given", stderr=None):
    error = abs(estimate - true) / abs(true) if true else None
    known = {"true": true, "true_kind": kind, "crb_sd": crb_sd, "identifiable": identifiable, "stderr": stderr}
    return {"estimate": estimate, "rel_error": error} | known


def outcome(*rows, **prediction):
    estimate = types.SimpleNamespace(predictor=None, covariance=None)
    return Outcome(types.SimpleNamespace(measured=False, held_out=()), estimate, rows, prediction)


def test_scores_stand_in_the_order_of_their_columns():
    of_parameters, of_runs = ["parameter_error", "efficiency", "probability"], ["prediction_error", "spread"]
    assert list(scores()) == [*of_parameters, *of_runs, "record_errors"]
    columns = list(result_columns())
    first = columns.index("rel_error_median")
    assert columns[first : first + len(score_columns())] == list(score_columns())


def test_scores_by_hand():
    found = compute(outcome(row(2.2, 2.0, 0.1), row(-1.4, -1.0, 0.2), row(0.3, 0.0, 0.1), row(50.0, 5.0, 9.0, False)))
    assert found["rel_error_median"] == pytest.approx(0.25) and found["rel_error_max"] == pytest.approx(0.4)
    assert found["crb_z_rms"] == pytest.approx(2.0) and len(found) == 3


def test_the_probability_score_is_the_integral_of_its_definition():
    """CRPS: the squared distance of the stated distribution from the step at the true value, integrated."""
    x = np.linspace(-20.0, 30.0, 400_001)
    expected = float(np.trapezoid((norm.cdf(x, 2.2, 0.5) - (x >= 2.0)) ** 2, x)) / 2.0
    found = compute(outcome(row(2.2, 2.0, 0.1, stderr=0.5)))
    assert found["crps_median"] == pytest.approx(expected, rel=1e-3) and found["coverage_95"] == 1.0
    wrong, unknown = row(5.0, 2.0, 0.1, stderr=1.0), row(5.0, 2.0, 0.1, stderr=float("inf"))
    assert compute(outcome(row(2.2, 2.0, 0.1, stderr=0.5), wrong, unknown))["coverage_95"] == 0.5
    assert compute(outcome(row(2.2, 2.0, 0.1, stderr=1e-9)))["crps_median"] == pytest.approx(0.1)
    assert "crps_median" not in compute(outcome(row(2.2, 2.0, 0.1)))


def test_an_infinite_bound_does_not_count():
    found = compute(outcome(row(2.2, 2.0, 0.1), row(3.0, 1.0, float("inf"))))
    assert found["crb_z_rms"] == pytest.approx(2.0) and found["rel_error_max"] == pytest.approx(2.0)


def test_a_model_of_another_family_than_the_truth_is_not_compared_with_a_bound():
    found = compute(outcome(row(2.2, 2.0, 0.1, kind="derived"), row(1.3, 1.0, 1e-6, kind="derived")))
    assert found["rel_error_median"] == pytest.approx(0.2) and "crb_z_rms" not in found


def test_without_truth_there_are_no_errors_of_parameters():
    unknown = {"estimate": 2.2, "true": None, "crb_sd": None, "identifiable": None, "rel_error": None, "stderr": None}
    assert compute(outcome(unknown)) == {}


def test_predictions_are_copied_to_their_columns_only():
    found = compute(outcome(diverged=False, rmse_free_heading_rad=0.1, rmse_free_roll_rad=0.2))
    assert found == {"rmse_free_heading_rad": 0.1}
