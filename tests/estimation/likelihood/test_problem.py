"""The output-error problem: derivatives, and pieces of long records."""

import numpy as np
import pytest

from helmbench.estimation import free_run
from helmbench.estimation.likelihood.problem import free_start_problem
from helmbench.estimation.series import series_of
from helmbench.methods.output_error import OutputError
from helmbench.models.model import resolve

from ...records import driven


@pytest.mark.parametrize("vessel", ["response-2", "kvlcc2-l7"])
def test_factor_holds_the_derivatives(vessel, rng):
    """R'R of the folded factor is J'J of derivatives by finite differences, initial states included."""
    model = resolve(vessel)
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


def test_pieces_make_no_difference(suite, monkeypatch):
    model, records = suite("response-2", noise="low")
    whole = OutputError().fit(records, model)
    monkeypatch.setattr(free_run, "PIECE", 2000)
    pieces = OutputError().fit(records, model)
    assert pieces.coefficients == pytest.approx(whole.coefficients, rel=1e-6)
