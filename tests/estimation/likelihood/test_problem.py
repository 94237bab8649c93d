"""The output-error problem: derivatives, and pieces of long records."""

from dataclasses import replace

import numpy as np
import pytest

from helmbench.estimation.likelihood import problem as problems
from helmbench.estimation.likelihood.loss import loss_of
from helmbench.estimation.likelihood.problem import free_start_problem, sensor_sd_of
from helmbench.estimation.likelihood.shooting import shooting_problem
from helmbench.estimation.methods_only.prior_knowledge import unknowns_of
from helmbench.estimation.records.series import series_of
from helmbench.estimation.simulation import free_run
from helmbench.methods.output_error import OutputError
from helmbench.models.model import resolve

from ...made_up.records import driven


@pytest.mark.parametrize("vessel", ["response-2", "kvlcc2-l7"])
def test_factor_holds_the_derivatives(vessel, rng):
    """R'R of the folded factor is J'J of derivatives by finite differences, initial states included; the tangent's own
    error of integration is small at this step."""
    model = replace(resolve(vessel), max_step_s=0.025)
    record = driven(model, 0.3 * np.sin(0.1 * np.arange(150)) + 0.1, 0.2)
    series = [series_of(record, model)]
    problem = free_start_problem(series, model)
    z = problem.start(model.coefficients)
    point = problem.at(z)._replace(sd=np.ones(len(model.states)))

    def residual(z):
        moved, ((s, state, _, _),) = problem.unpack(z)
        return free_run.residuals(moved, s, state).T.ravel()

    columns = []
    for i in range(z.size):
        step = np.zeros(z.size)
        step[i] = 1e-6 * max(abs(z[i]), 0.1)
        columns.append((residual(z - step) - residual(z + step)) / (2.0 * step[i]))
    jacobian = np.array(columns).T
    factor = problem.factor(point)
    scale = np.linalg.norm(jacobian, axis=0)
    expected = jacobian.T @ jacobian / np.outer(scale, scale)
    found = factor[:, :-1].T @ factor[:, :-1] / np.outer(scale, scale)
    assert found == pytest.approx(expected, abs=5e-4)


@pytest.mark.parametrize("loss", [None, loss_of("huber", None)])
@pytest.mark.parametrize("stretches", [1, 4])
def test_rows_hold_the_factor_and_the_derivatives_of_the_residuals(suite, rng, loss, stretches):
    """R'R of the rows is that of the factor; their slopes are those of `residuals`; prior and jumps are among them."""
    model, records = suite("response-2", noise="medium")
    unknowns = unknowns_of(model, prior=0.5, bounds=None, fixed=None)
    series = [series_of(record, model) for record in records]
    problem = free_start_problem(series, model, unknowns, loss)
    if stretches > 1:
        problem = shooting_problem(replace(problem, sensor=sensor_sd_of(problem)), stretches)
    z = problem.start(unknowns.mean[unknowns.estimated] * rng.uniform(0.9, 1.1, size=problem.n_parameters))
    point = problem.at(z)
    rows, factor = problem.rows(point), problem.factor(point)
    scale = np.linalg.norm(rows, axis=0)
    assert (rows / scale).T @ (rows / scale) == pytest.approx((factor / scale).T @ (factor / scale), abs=1e-9)
    assert problem.residuals(z, point) == pytest.approx(rows[:, -1], rel=0.0, abs=1e-9)
    way = rng.normal(size=z.size) / scale[:-1]
    change = (problem.residuals(z - 1e-4 * way, point) - problem.residuals(z + 1e-4 * way, point)) / 2e-4
    assert np.linalg.norm(change - rows[:, :-1] @ way) < 1e-5 * np.linalg.norm(change)


def test_derivatives_that_would_need_too_much_memory_are_not_kept(suite, monkeypatch):
    model, records = suite("response-2", noise="medium")
    problem = free_start_problem([series_of(record, model) for record in records], model)
    point = problem.at(problem.start(model.coefficients))
    assert problem.rows(point).shape == (sum(s.n_outputs for s in problem.series), problem.width + 1)
    monkeypatch.setattr(problems, "MOST_NUMBERS", 1000)
    assert problem.rows(point) is None


def test_pieces_make_no_difference(suite, monkeypatch):
    model, records = suite("response-2", noise="low")
    whole = OutputError().fit(records, model)
    monkeypatch.setattr(free_run, "PIECE", 2000)
    pieces = OutputError().fit(records, model)
    assert pieces.coefficients == pytest.approx(whole.coefficients, rel=1e-6)
