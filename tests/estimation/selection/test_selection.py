"""Normal equations, scores, fits and selection against closed forms of linear Gaussian problems."""

from dataclasses import dataclass, field

import numpy as np
import pytest
from scipy.optimize import least_squares

from helmbench.estimation.selection.minimiser import minimise, point_at, prior_of
from helmbench.estimation.selection.number import Candidate, Number
from helmbench.estimation.selection.quadratic import (
    Quadratic,
    bounded_solve,
    joint,
    left_out_steps,
    own_information,
    own_step,
)
from helmbench.estimation.selection.score import fall, jackknife, score
from helmbench.estimation.selection.selection import Rules, clearly_worse, select

UNITS, SAMPLES, CHANNELS = 7, 40, 2


@dataclass
class Linear:
    """y = J x + L z + noise in units; `bend` makes the first number act as x + bend x^2."""

    columns: dict  # name -> (K, N, C)
    own_columns: np.ndarray  # (m, K, N, C)
    data: np.ndarray  # (K, N, C)
    own_sd: np.ndarray
    floor: np.ndarray = field(default_factory=lambda: np.full(CHANNELS, 1e-3))
    bend: float = 0.0
    known: np.ndarray = field(default_factory=lambda: np.zeros(CHANNELS, bool))

    @property
    def counts(self):
        return np.full((len(self.data), CHANNELS), float(SAMPLES))

    @property
    def noise(self):
        return np.zeros(CHANNELS)

    @property
    def weight(self):
        return np.full(len(self.data), 0.5)

    def errors(self, values, own):
        """(K, N, C) of values by unit and own effects (K, m)."""
        out = self.data - np.einsum("mknc,km->knc", self.own_columns, own)
        for name, column in self.columns.items():
            x = np.array([v.get(name, 0.0) for v in values])
            out = out - column * (x + (self.bend * x**2 if name == "a" else 0.0))[:, None, None]
        return out

    def squares(self, values, own):
        return np.sum(self.errors(values, own) ** 2, axis=1)

    def quadratic(self, values, own, numbers):
        slope = {n.name: 1.0 + (2.0 * self.bend * values.get("a", 0.0) if n.name == "a" else 0.0) for n in numbers}
        rows = [-slope[n.name] * self.columns[n.name] for n in numbers]
        rows += [*-self.own_columns, self.errors([values] * len(own), own)]
        z = np.array(rows)
        return Quadratic(np.einsum("iknc,jknc->kcij", z, z), self.weight, own, self.own_sd)


def problem(rng, names="abcd", noise=0.1, orthogonal=False, **truth):
    shape = (UNITS, SAMPLES, CHANNELS)
    rows = rng.standard_normal((len(names), *shape))
    if orthogonal:
        q, _ = np.linalg.qr(rows.reshape(len(names), -1).T)
        rows = (q.T * np.sqrt(q.shape[0])).reshape(rows.shape)
    columns = dict(zip(names, rows, strict=True))
    own_columns = np.ones((1, *shape))
    own = 0.2 * rng.standard_normal((UNITS, 1))
    data = noise * rng.standard_normal(shape) + own[:, None, :]
    for name, x in truth.items():
        data = data + columns[name] * x
    return Linear(columns, own_columns, data, np.array([0.2]))


def numbers(names, sd=2.0):
    return [Number(name, sd) for name in names]


def none(p):
    return np.zeros((len(p.data), p.own_sd.size))


def whole_solve(p, names, size, sd, kept):
    """Numbers and own effects of some units by one dense solve of all columns."""
    k, m = len(names), p.own_sd.size
    rows, target = [], []
    for i, unit in enumerate(kept):
        design = np.zeros((SAMPLES, CHANNELS, k + m * len(kept)))
        for j, name in enumerate(names):
            design[..., j] = p.columns[name][unit]
        design[..., k + m * i : k + m * (i + 1)] = np.moveaxis(p.own_columns[:, unit], 0, -1)
        root = np.sqrt(p.weight[unit]) / size
        rows.append((design * root[:, None]).reshape(-1, design.shape[-1]))
        target.append((p.data[unit] * root).ravel())
    x, y = np.vstack(rows), np.concatenate(target)
    prior = np.concatenate([np.full(k, sd), np.tile(p.own_sd, len(kept))])
    return np.linalg.solve(x.T @ x + np.diag(prior**-2.0), x.T @ y)


def test_elimination_of_own_effects_equals_the_joint_solve(rng):
    p, size = problem(rng, a=0.5, b=-0.3), np.array([0.1, 0.3])
    quadratic = p.quadratic({}, none(p), numbers("abc"))
    normal, prior = quadratic.normal(size), prior_of(numbers("abc"), {})
    step = np.linalg.solve(*joint(normal, prior))
    expected = whole_solve(p, "abc", size, 2.0, range(UNITS))
    assert np.allclose(step, expected[:3], rtol=1e-9)
    own = own_step(normal, np.tile(step, (UNITS, 1)))
    assert np.allclose(own[:, 0], expected[3:], rtol=1e-8)
    gone = quadratic.squares(np.tile(step, (UNITS, 1)), own, range(3))
    assert np.allclose(gone, p.squares([dict(zip("abc", step, strict=True))] * UNITS, own), rtol=1e-9)


def test_a_subset_of_numbers_is_its_own_problem(rng):
    p, size = problem(rng, a=0.5), np.array([0.2, 0.2])
    part = p.quadratic({}, none(p), numbers("abcd")).normal(size).of([2, 0])
    alone = p.quadratic({}, none(p), numbers("ca")).normal(size)
    assert all(np.allclose(one, other) for one, other in zip(part, alone, strict=True))


def test_left_out_units_are_those_of_refits(rng):
    p, size = problem(rng, a=0.5, b=-0.3), np.array([0.1, 0.1])
    quadratic = p.quadratic({}, none(p), numbers("abc"))
    normal, prior = quadratic.normal(size), prior_of(numbers("abc"), {})
    steps, squares = left_out_steps(normal, prior), quadratic.left_out(normal, range(3), prior)
    for unit in range(UNITS):
        others = [k for k in range(UNITS) if k != unit]
        expected = whole_solve(p, "abc", size, 2.0, others)[:3]
        assert np.allclose(steps[unit], expected, rtol=1e-9)
        rest = p.data[unit] - sum(p.columns[n][unit] * x for n, x in zip("abc", expected, strict=True))
        weight = p.weight[unit] / size**2
        own = np.sum(rest.sum(axis=0) * weight) / (np.sum(SAMPLES * weight) + p.own_sd[0] ** -2.0)
        assert np.allclose(squares[unit], np.sum((rest - own) ** 2, axis=0), rtol=1e-8)


def test_random_effects_have_the_marginal_likelihood(rng):
    """The penalised minimum and its determinant are the likelihood of y ~ N(0, R + J S J^T)."""
    p, size, sd = problem(rng, a=0.5), np.array([0.3, 0.3]), 0.7
    p.own_sd = np.array([1e-9])
    quadratic = p.quadratic({}, none(p), numbers("ab", sd))
    normal, prior = quadratic.normal(size), prior_of(numbers("ab", sd), {})
    matrix, slope = joint(normal, prior)
    step = np.linalg.solve(matrix, slope)
    design = np.stack([p.columns[n].ravel() for n in "ab"], axis=1)
    noise = np.tile(size**2 / p.weight[0], UNITS * SAMPLES)
    covariance = np.diag(noise) + sd**2 * design @ design.T
    y = p.data.ravel()
    exact = y @ np.linalg.solve(covariance, y) + np.linalg.slogdet(covariance)[1]
    left = y - design @ step
    laplace = np.sum(left**2 / noise) + np.sum((step / sd) ** 2) + np.log(noise).sum()
    laplace += np.linalg.slogdet(matrix)[1] + 2.0 * len(step) * np.log(sd)
    assert laplace == pytest.approx(exact, rel=1e-9)


def test_the_information_that_other_numbers_leave(rng):
    p = problem(rng, "abc", orthogonal=True)
    p.columns["b"] = p.columns["a"] + p.columns["b"]
    p.own_sd = np.array([1e-9])
    chosen = numbers("abc", 1e3)
    normal, prior = p.quadratic({}, none(p), chosen).normal(np.array([0.1, 0.1])), prior_of(chosen, {})
    assert own_information(normal.of([0, 1]), prior.of([0, 1]), 1) == pytest.approx(0.5, rel=1e-6)
    assert own_information(normal.of([0, 2]), prior.of([0, 2]), 1) == pytest.approx(1.0, rel=1e-6)


def test_what_the_free_numbers_take_up_is_not_tried(rng):
    p = problem(rng, "abc", a=0.5, c=0.5)
    p.columns["b"] = 1.001 * p.columns["a"]
    always = numbers("a")
    found = select(p, singles("bc"), Rules(), minimise(p, always, {}, none(p)), always)
    assert [c.id for c in found.candidates] == ["c"]


def test_bounds_hold_and_the_rest_is_solved_again(rng):
    a = rng.standard_normal((9, 3))
    matrix, slope = a.T @ a, a.T @ np.array([4.0, *rng.standard_normal(8)])
    free = np.linalg.solve(matrix, slope)
    low, high = np.full(3, -np.inf), np.full(3, np.inf)
    assert np.allclose(bounded_solve(matrix, slope, low, high), free)
    high[0] = free[0] - 0.5
    step = bounded_solve(matrix, slope, low, high)
    assert step[0] == high[0]
    rest = np.linalg.solve(matrix[1:, 1:], slope[1:] - matrix[1:, 0] * high[0])
    assert np.allclose(step[1:], rest)


def test_jackknife_of_a_mean_is_its_standard_error(rng):
    x = rng.standard_normal(30)
    without = (x.sum() - x) / 29
    assert jackknife(without) == pytest.approx(np.std(x, ddof=1) / np.sqrt(30))


def test_the_error_of_a_fall_is_the_jackknife_over_units(rng):
    old, new = rng.uniform(2.0, 3.0, (6, 3)), rng.uniform(1.0, 2.0, (6, 3))
    floor = np.full((6, 3), 0.1)
    found = fall(old, new, floor)
    assert found.gain == pytest.approx(score(old + floor) - score(new + floor))
    without = [fall(np.delete(old, k, 0), np.delete(new, k, 0), np.delete(floor, k, 0)).gain for k in range(6)]
    assert found.error == pytest.approx(float(jackknife(np.array(without))))


def test_the_minimum_is_that_of_least_squares(rng):
    p = problem(rng, noise=0.3, a=0.8, b=-0.3)
    p.bend = 0.4
    chosen = numbers("ab", 5.0)
    fitted = minimise(p, chosen, {}, none(p), steps=60)

    def cost(x):
        return point_at(p, chosen, dict(zip("ab", x[:2], strict=True)), x[2:].reshape(UNITS, 1)).cost

    def residuals(x, size):
        errors = p.errors([dict(zip("ab", x[:2], strict=True))] * UNITS, x[2:].reshape(UNITS, 1))
        weighted = (errors / size * np.sqrt(p.weight[0])).ravel()
        return np.concatenate([weighted, x[:2] / 5.0, x[2:] / p.own_sd[0]])

    x = np.zeros(2 + UNITS)
    for _ in range(40):  # sizes and least squares in turn: the concentrated optimum
        size = point_at(p, chosen, dict(zip("ab", x[:2], strict=True)), x[2:].reshape(UNITS, 1)).size
        x = least_squares(residuals, x, args=(size,)).x
    assert fitted.point.cost == pytest.approx(cost(x), abs=0.05)
    assert [fitted.value(n) for n in "ab"] == pytest.approx(x[:2].tolist(), abs=3e-3)


def test_a_fit_keeps_to_bounds_and_is_better_than_its_start(rng):
    p = problem(rng, a=0.8, b=-0.3)
    chosen = [Number("a", 2.0, high=0.5), Number("b", 2.0)]
    fitted = minimise(p, chosen, {}, none(p))
    assert fitted.value("a") == 0.5
    assert fitted.point.cost < point_at(p, chosen, {}, none(p)).cost


def base(p):
    return minimise(p, (), {}, none(p))


def singles(names, **more):
    return [Candidate(name, (Number(name, 2.0),), **more) for name in names]


def test_an_orthogonal_design_gives_the_true_subset(rng):
    p = problem(rng, "abcdef", orthogonal=True, b=0.5, e=-0.4)
    found = select(p, singles("abcdef"), Rules(), base(p))
    assert {c.id for c in found.candidates} == {"b", "e"}
    assert found.final.value("b") == pytest.approx(0.5, abs=4.0 * found.final.sd[0])
    assert not any(one.tied_with for one in found.entered)


def test_nothing_enters_where_there_is_nothing(rng):
    p = problem(rng, "abcdef")
    assert select(p, singles("abcdef"), Rules(least=0.004, level=0.999), base(p)).entered == ()


def test_a_tie_is_told_and_the_lower_rank_goes_first(rng):
    p = problem(rng, "ab", a=0.5)
    p.columns["b"] = p.columns["a"] + 1e-3 * p.columns["b"]
    bank = [*singles("a", rank=1), *singles("b", rank=0)]
    found = select(p, bank, Rules(), base(p))
    assert [one.candidate.id for one in found.entered] == ["b"]
    assert [c.id for c in found.entered[0].tied_with] == ["a"]


@pytest.mark.parametrize("worse", [{"extends": True}, {"high": 0.45}])
def test_of_two_that_are_alike_a_new_term_and_a_number_at_its_bound_come_last(worse, rng):
    """Column b is a little nearer to the errors than a, but b is a term that the model lacks, or ends at its bound."""
    p = problem(rng, "ab", a=0.5)
    p.columns["b"] = p.columns["a"]
    p.columns["a"] = p.columns["a"] + 0.02 * rng.standard_normal(p.columns["a"].shape)
    number = Number("b", 2.0, high=worse.get("high", np.inf))
    bank = [*singles("a"), Candidate("b", (number,), extends="extends" in worse)]
    (entered,) = select(p, bank, Rules(least=0.5), base(p)).entered
    assert entered.candidate.id == "a"
    (alone,) = select(p, singles("ab"), Rules(least=0.5), base(p)).entered
    assert alone.candidate.id == "b"


def test_numbers_of_one_group_that_would_do_as_well_are_told(rng):
    p = problem(rng, "abc", a=0.5)
    p.columns["b"] = p.columns["a"] + 1e-3 * p.columns["b"]
    (entered,) = select(p, singles("abc", of="group"), Rules(), base(p)).entered
    assert entered.tied_with == () and {entered.candidate.id, *(c.id for c in entered.alike)} == {"a", "b"}


def test_what_a_later_one_makes_needless_leaves_again(rng):
    p = problem(rng, "abm", a=0.5, b=0.5)
    p.columns["m"] = p.columns["a"] + p.columns["b"] + 0.9 * p.columns["m"]
    found = select(p, singles("abm"), Rules(), base(p))
    assert {c.id for c in found.candidates} == {"a", "b"}


def test_a_group_gives_way_to_the_one_number_of_it(rng):
    p = problem(rng, "abcd", a=0.5)
    bank = [Candidate("group", tuple(numbers("abc"))), *singles("abcd", of="group")]
    found = select(p, bank, Rules(), base(p))
    assert [c.id for c in found.candidates] == ["a"]


def test_enough_is_enough(rng):
    p = problem(rng, "ab", a=0.5)
    assert select(p, singles("ab"), Rules(enough=np.full(2, 10.0)), base(p)).entered == ()


def test_one_more_has_to_come_nearer_to_enough(rng):
    """The effects of b and e, .5 and .2, with noise of .1: e takes the error from about .22 to .1."""
    p = problem(rng, "abcdef", orthogonal=True, b=0.5, e=0.2)
    for nearer, expected in ((0.95, {"b", "e"}), (0.3, {"b"})):
        rules = Rules(enough=np.full(2, 0.01), nearer=nearer)
        assert {c.id for c in select(p, singles("abcdef"), rules, base(p)).candidates} == expected


def test_clearly_worse_asks_for_more_than_chance(rng):
    p = problem(rng, "ab", a=0.5)
    right, wrong = (minimise(p, numbers(name), {}, none(p)) for name in "ab")
    assert clearly_worse(p, wrong, right, 0.0) and not clearly_worse(p, right, wrong, 0.0)
