"""Levenberg-Marquardt on the output-error problem."""

import numpy as np
import pytest

from helmbench.estimation.likelihood.linear_problem import LinearProblem
from helmbench.estimation.likelihood.minimiser import Damping, levenberg_marquardt, try_steps
from helmbench.estimation.likelihood.problem import Point, free_start_problem
from helmbench.estimation.records.series import series_of


def test_steps_never_make_it_worse(suite):
    model, records = suite("response-2", noise="medium")
    problem = free_start_problem([series_of(r.turned(model.positive_rudder), model) for r in records], model)
    start = problem.start(1.2 * model.coefficients)
    costs = [levenberg_marquardt(problem, start, most).cost for most in (0, 1, 2, 4, 8, 30)]
    assert np.all(np.diff(costs) <= 0.0) and costs[-1] < costs[0] - 100.0


class Parabola:
    """cost = |x|^2/2 at a point."""

    def __init__(self, x):
        self.x, self.cost = x, 0.5 * float(x @ x)


def test_the_undamped_step_solves_a_linear_problem(rng):
    """Without damping the step is that of least squares, and the predicted gain is the actual one."""
    a, b = rng.normal(size=(20, 3)) * [1.0, 1e4, 1e-4], rng.normal(size=20)
    linear = LinearProblem(np.column_stack([a, b]))
    step, predicted = linear.step(0.0)
    assert step == pytest.approx(np.linalg.lstsq(a / [1.0, 1e4, 1e-4], b, rcond=None)[0] / [1.0, 1e4, 1e-4], rel=1e-9)
    assert predicted == pytest.approx(0.5 * (b @ b - np.sum((b - a @ step) ** 2)), rel=1e-9)
    reach = 0.5 * np.abs(step)
    inside, less = linear.step_within(0.0, -reach, reach)
    assert np.all(np.abs(inside) <= reach) and 0.0 < less < predicted


def test_damping_grows_until_a_step_is_better():
    """Steps of ten times the right length overshoot until they are damped."""
    start = Parabola(np.array([1.0]))
    calls = []

    def step(damping):
        calls.append(damping)
        return -10.0 * start.x / (1.0 + damping), 1.0

    trial = try_steps(step, lambda move: Parabola(start.x + move), start.cost, 1.0, 1e-3, Damping(growth=3.0))
    assert trial.better and trial.number == 2 and trial.damping == calls[-1] == 9.0
    given_up = try_steps(step, lambda move: start, start.cost, 1.0, 1e-3, Damping(growth=3.0, trials=4))
    assert not given_up.better and given_up.number == 3


class Valley:
    """Residuals 1 - x and steep (y - x^2): a narrow curved valley from the start to the minimum at (1, 1)."""

    arrow_shaped, sensor, width, steep = False, None, 2, 1e3

    def __init__(self, bent):
        self.bent = bent

    def limits(self):
        return None

    def at(self, z):
        r = self.residuals(z, None)
        return Point(z, 0.5 * float(r @ r), r**2, np.ones(2))

    def residuals(self, z, point):
        return np.array([1.0 - z[0], self.steep * (z[0] ** 2 - z[1])])

    def _rows(self, z):
        slopes = np.array([[1.0, 0.0], [-2.0 * self.steep * z[0], self.steep]])
        return np.column_stack([slopes, self.residuals(z, None)])

    def factor(self, point):
        return np.linalg.qr(self._rows(point.z), mode="r")

    def rows(self, point):
        return self._rows(point.z) if self.bent else None


def test_acceleration_follows_a_curved_valley(rng):
    start = np.array([-1.0, 1.0]) * rng.uniform(1.0, 2.0)
    straight, bent = (levenberg_marquardt(Valley(bent), start, 1000, 1e-12) for bent in (False, True))
    print(start, straight.n_iterations, bent.n_iterations)
    assert straight.converged and bent.converged
    assert bent.z == pytest.approx([1.0, 1.0], abs=1e-5)
    assert bent.n_iterations < 0.5 * straight.n_iterations
