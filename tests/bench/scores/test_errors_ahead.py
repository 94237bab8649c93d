"""Errors ahead of runs on measured records, beside predictions without a model."""

from dataclasses import replace

import numpy as np
import pytest

from helmbench.bench.kinds.identification.problems import Task, problem
from helmbench.bench.scores.base import Outcome
from helmbench.bench.scores.errors_ahead import errors_ahead
from helmbench.methods.registry import make


@pytest.fixture(scope="module")
def outcome():
    task = problem(
        Task("response-1", "response-1", "nomoto-1-cubic", ("zigzag:20/20",), ("zigzag:10/10",), noise="low")
    )
    estimate = make("output-error").fit(list(task.train), task.model)
    return Outcome(replace(task, measured=True), estimate, (), {})


def test_a_good_model_is_trusted_and_better_than_no_model(outcome):
    found = errors_ahead.compute(outcome)
    assert set(found) <= set(errors_ahead.columns) and found["trusted_s"] > 0.0
    for name, value in found.items():
        prefix, _, rest = name.removeprefix("rmse_").partition("_")
        if name.startswith("rmse_ahead") and prefix == "ahead" and np.isfinite(value):
            assert value < found[f"rmse_turning_{rest}"] and value < found[f"rmse_straight_{rest}"]


def test_simulated_records_have_no_such_scores(outcome):
    assert errors_ahead.compute(replace(outcome, problem=replace(outcome.problem, measured=False))) == {}
