"""Scores of parameters against the truth."""

import types

import pytest

from helmbench.bench import scores
from helmbench.bench.kinds.identification.problems import Truth


def estimate_of(**values):
    return types.SimpleNamespace(parameters=values, stderr=dict.fromkeys(values, 0.1))


def test_parameter_rows_and_scores_by_hand():
    model = types.SimpleNamespace(parameter_names=("a", "b", "c", "d"), parameter_units=("s", "1/s", "", ""))
    truth = Truth(
        values={"a": 2.0, "b": -1.0, "c": 0.0, "d": 5.0},
        kind="given",
        crb_sd={"a": 0.1, "b": 0.2, "c": 0.1, "d": 9.0},
        identifiable={"a": True, "b": True, "d": False},
    )
    rows = scores.parameter_rows(model, truth, estimate_of(a=2.2, b=-1.4, c=0.3, d=50.0))
    assert [row["rel_error"] for row in rows] == [pytest.approx(0.1), pytest.approx(0.4), None, 9.0]
    assert [row["identifiable"] for row in rows] == [True, True, None, False]
    assert [row["true_kind"] for row in rows] == ["given"] * 4
    found = scores.parameter_scores(rows)
    assert found["rel_error_median"] == pytest.approx(0.25) and found["rel_error_max"] == pytest.approx(0.4)
    assert found["crb_z_rms"] == pytest.approx(2.0)


def test_without_truth_there_are_estimates_only():
    model = types.SimpleNamespace(parameter_names=("a",), parameter_units=("s",))
    rows = scores.parameter_rows(model, Truth(), estimate_of(a=2.2))
    assert rows == [
        {"parameter": "a", "unit": "s", "true": None, "true_kind": None, "estimate": 2.2, "stderr": 0.1,
         "rel_error": None, "crb_sd": None, "identifiable": None}
    ]  # fmt: skip
    assert scores.parameter_scores(rows) == {}
