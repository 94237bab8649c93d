"""Scores: found by the registry, each filling its columns."""

import types

import pytest

from helmbench.bench.kinds.identification.columns import result_columns
from helmbench.bench.scores import Outcome, compute, score_columns, scores


def row(estimate, true, crb_sd, identifiable=True, kind="given"):
    error = abs(estimate - true) / abs(true) if true else None
    known = {"true": true, "true_kind": kind, "crb_sd": crb_sd, "identifiable": identifiable}
    return {"estimate": estimate, "rel_error": error} | known


def outcome(*rows, **prediction):
    return Outcome(types.SimpleNamespace(measured=False), types.SimpleNamespace(), rows, prediction)


def test_scores_stand_in_the_order_of_their_columns():
    assert list(scores()) == ["parameter_error", "efficiency", "prediction_error", "errors_ahead", "record_errors"]
    columns = list(result_columns())
    first = columns.index("rel_error_median")
    assert columns[first : first + len(score_columns())] == list(score_columns())


def test_scores_by_hand():
    found = compute(outcome(row(2.2, 2.0, 0.1), row(-1.4, -1.0, 0.2), row(0.3, 0.0, 0.1), row(50.0, 5.0, 9.0, False)))
    assert found["rel_error_median"] == pytest.approx(0.25) and found["rel_error_max"] == pytest.approx(0.4)
    assert found["crb_z_rms"] == pytest.approx(2.0) and len(found) == 3


def test_an_infinite_bound_does_not_count():
    found = compute(outcome(row(2.2, 2.0, 0.1), row(3.0, 1.0, float("inf"))))
    assert found["crb_z_rms"] == pytest.approx(2.0) and found["rel_error_max"] == pytest.approx(2.0)


def test_a_model_of_another_family_than_the_truth_is_not_compared_with_a_bound():
    found = compute(outcome(row(2.2, 2.0, 0.1, kind="derived"), row(1.3, 1.0, 1e-6, kind="derived")))
    assert found["rel_error_median"] == pytest.approx(0.2) and "crb_z_rms" not in found


def test_without_truth_there_are_no_errors_of_parameters():
    unknown = {"estimate": 2.2, "true": None, "crb_sd": None, "identifiable": None, "rel_error": None}
    assert compute(outcome(unknown)) == {}


def test_predictions_are_copied_to_their_columns_only():
    found = compute(outcome(diverged=False, rmse_free_heading_rad=0.1, rmse_free_roll_rad=0.2))
    assert found == {"rmse_free_heading_rad": 0.1}
