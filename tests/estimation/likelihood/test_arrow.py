"""Own unknowns eliminated record by record, against the same problem as one matrix."""

import numpy as np
import pytest

import helmbench
from helmbench.estimation.likelihood import problem as problems
from helmbench.estimation.likelihood.linear_problem import Arrow, LinearArrow, LinearProblem, RecordRows
from helmbench.methods.output_error import OutputError
from helmbench.models.model import resolve

SHARED = 4


def matrices(rng, sizes, free=(2, 3, 2)):
    """An arrow, and the same rows in all columns: shared unknowns, own unknowns, right side."""
    width = SHARED + sum(free)
    parts, dense, place = [], [], SHARED
    for rows, own in zip(sizes, free, strict=True):
        values = rng.normal(size=(rows, own + SHARED + 1)) * 10.0 ** rng.uniform(-2, 2, own + SHARED + 1)
        wide = np.zeros((rows, width + 1))
        wide[:, place : place + own], wide[:, :SHARED], wide[:, -1] = values[:, :own], values[:, own:-1], values[:, -1]
        parts.append(RecordRows(place, own, values))
        dense.append(wide)
        place += own
    prior = rng.normal(size=(2, SHARED + 1))
    wide = np.zeros((2, width + 1))
    wide[:, :SHARED], wide[:, -1] = prior[:, :-1], prior[:, -1]
    return Arrow.of(parts, prior), np.vstack([*dense, wide])


@pytest.mark.parametrize("damping", [1e-12, 1e-3, 10.0])
@pytest.mark.parametrize("sizes", [(30, 40, 50), (3, 40, 8)])
def test_steps_are_those_of_the_whole_matrix(rng, damping, sizes):
    arrow, dense = matrices(rng, sizes)
    step, gain = LinearArrow(arrow).step(damping)
    expected, predicted = LinearProblem(np.linalg.qr(dense, mode="r")).step(damping)
    np.testing.assert_allclose(step, expected, rtol=1e-6, atol=1e-8 * np.abs(expected).max())
    assert gain == pytest.approx(predicted, rel=1e-7)


def test_bounds_hold_for_the_shared_unknowns(rng):
    arrow, dense = matrices(rng, (30, 40, 50))
    free = LinearArrow(arrow).step(1e-6)[0]
    low, high = np.full(free.size, -np.inf), np.full(free.size, np.inf)
    low[0], high[0] = -0.5 * abs(free[0]), 0.5 * abs(free[0])
    step, gain = LinearArrow(arrow).step_within(1e-6, low, high)
    expected, predicted = LinearProblem(np.linalg.qr(dense, mode="r")).step_within(1e-6, low, high)
    np.testing.assert_allclose(step, expected, rtol=1e-5, atol=1e-7 * np.abs(expected).max())
    assert gain == pytest.approx(predicted, rel=1e-6)
    assert abs(step[0]) == pytest.approx(0.5 * abs(free[0]))


def test_numbers_that_are_not_finite_are_seen(rng):
    arrow, _ = matrices(rng, (30, 40, 50))
    assert arrow.finite
    assert not Arrow(arrow.own, arrow.shared * np.nan).finite


@pytest.mark.parametrize("options", [{}, {"loss": "huber"}, {"prior": 0.5, "bounds": {"K": (0.0, 1.0)}}])
def test_a_fit_of_many_records_is_the_same_either_way(monkeypatch, options):
    """By straight steps: an arrow's are not accelerated."""
    monkeypatch.setattr(problems, "MOST_NUMBERS", 0)
    runs = helmbench.simulate_many("response-2", "prbs:20deg/3s", 12, noise="medium", duration_s=10.0)
    records, model = [runs.record(i) for i in range(len(runs))], resolve("response-2")
    whole = OutputError(**options).fit(records, model)
    monkeypatch.setattr(problems, "WIDE", 1)
    apart = OutputError(**options).fit(records, model)
    assert whole.converged and apart.converged and whole.message == apart.message
    sd = np.sqrt(np.diag(whole.covariance))
    np.testing.assert_allclose(apart.coefficients, whole.coefficients, rtol=0.0, atol=1e-3 * sd.min())
    np.testing.assert_allclose(
        apart.covariance, whole.covariance, rtol=1e-4, atol=1e-6 * np.abs(whole.covariance).max()
    )
