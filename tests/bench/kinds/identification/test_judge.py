"""Estimates against the truth, by hand."""

import types

import pytest

from helmbench.bench.kinds.identification.execute import parameter_rows
from helmbench.bench.kinds.identification.problems import Truth


def estimate_of(**values):
    return types.SimpleNamespace(parameters=values, stderr=dict.fromkeys(values, 0.1))


def test_parameters_are_compared_with_the_truth():
    model = types.SimpleNamespace(parameter_names=("a", "b", "c", "d"), parameter_units=("s", "1/s", "", ""))
    truth = Truth(
        values={"a": 2.0, "b": -1.0, "c": 0.0, "d": 5.0},
        kind="given",
        crb_sd={"a": 0.1, "b": 0.2, "c": 0.1, "d": 9.0},
        identifiable={"a": True, "b": True, "d": False},
    )
    rows = parameter_rows(model, truth, estimate_of(a=2.2, b=-1.4, c=0.3, d=50.0))
    assert [row["rel_error"] for row in rows] == [pytest.approx(0.1), pytest.approx(0.4), None, 9.0]
    assert [row["identifiable"] for row in rows] == [True, True, None, False]
    assert [row["true_kind"] for row in rows] == ["given"] * 4
    assert [row["unit"] for row in rows] == ["s", "1/s", "", ""]


def test_a_black_box_has_no_rows():
    assert parameter_rows(types.SimpleNamespace(), Truth(), estimate_of()) == []


def test_without_truth_there_are_estimates_only():
    model = types.SimpleNamespace(parameter_names=("a",), parameter_units=("s",))
    assert parameter_rows(model, Truth(), estimate_of(a=2.2)) == [
        {"parameter": "a", "unit": "s", "true": None, "true_kind": None, "estimate": 2.2, "stderr": 0.1,
         "rel_error": None, "crb_sd": None, "identifiable": None}
    ]  # fmt: skip
