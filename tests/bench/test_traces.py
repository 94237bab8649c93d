"""Stored traces: thinned free runs, and the log of a recursion."""

import numpy as np
import pytest

from helmbench.bench.traces import LOGGED, POINTS, free_run_trace, recursion_log
from helmbench.datasets.generator import Case, generate
from helmbench.methods.registry import make
from helmbench.models.model import resolve


@pytest.fixture(scope="module")
def record():
    return generate(Case("response-1", "zigzag:20/20", "low", seed=4))


@pytest.mark.parametrize("text", ["rls", "fw-rls", "mi-rls"])
def test_the_log_of_a_recursion_ends_at_its_estimate(record, text):
    estimate = make(text).fit(record, resolve("response-1"))
    trace = free_run_trace(estimate, record)
    log = trace["log"]
    assert list(log["values"]) == list(estimate.parameters) and len(log["time_s"]) == LOGGED
    assert all(len(path) == LOGGED for path in log["values"].values()) and len(trace["time_s"]) <= POINTS
    for name, value in estimate.parameters.items():
        assert log["values"][name][-1] == pytest.approx(value, rel=1e-4)
    assert np.all(np.diff(log["time_s"]) > 0.0) and log["time_s"][-1] <= record.time_s[-1]


def test_other_methods_have_no_log(record):
    estimate = make("ls").fit(record, resolve("response-1"))
    assert recursion_log(estimate) is None and "log" not in free_run_trace(estimate, record)
