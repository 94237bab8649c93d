"""Statistics of the leaderboard, against scipy, published examples and cases small enough for the hand."""

import math
from itertools import product

import numpy as np
import pytest
from scipy.stats import friedmanchisquare, wilcoxon

from helmbench.bench.kinds import IDENTIFICATION, kind_of
from helmbench.bench.store import frames
from helmbench.reporting.leaderboard import contest, paired, profiles, standings
from helmbench.reporting.leaderboard.answer import answer
from helmbench.reporting.leaderboard.estimates import summarised


def tables_of(runs):
    """The results of runs, and their parameters put together over seeds."""
    results, parameters = frames(runs, kind_of(IDENTIFICATION).tables)
    return results, summarised(parameters)


@pytest.fixture
def board_of():
    """The contest of stored runs."""

    def build(runs, criterion="prediction"):
        results, estimates = tables_of(runs)
        judged = standings.judged(results, estimates)
        return contest.contest(standings.cell_table(judged), judged, criterion)

    return build


@pytest.fixture
def eight_problems(run_of, rng):
    """Three methods on eight problems and two seeds: `a` is best and slow, `b` nearly as good and quick, `c` worse."""
    return problems(run_of, rng, 1.01)


def problems(run_of, rng, second):
    """Three methods on eight problems and two seeds: `a` is best and slow, `b` errs `second` times as much, `c` four
    times."""
    factors = {"a": (1.0, 3.0), "b": (second, 1.0), "c": (4.0, 0.5)}
    spread = {key: rng.normal(scale=0.02) for key in product("abc", range(8), range(2))}
    return [
        run_of(
            r2=1.0 - (0.01 * (p + 1) * factor * math.exp(spread[m, p, s])) ** 2,
            method=m, vessel=f"v{p // 2}", noise=("low", "medium")[p % 2], seed=s, cpu_s=seconds,
        )
        for m, (factor, seconds) in factors.items()
        for p, s in product(range(8), range(2))
    ]  # fmt: skip


def test_signed_ranks_are_those_of_scipy(rng):
    for n in (6, 12, 40, 80):
        first, second = rng.lognormal(size=(2, n))
        assert paired.signed_rank(first, second) == pytest.approx(wilcoxon(np.log(first / second)).pvalue, rel=1e-6)


def test_infinite_errors_are_the_largest_and_equal_among_each_other():
    first = np.array([1.0, 1.0, 1.0, 1.0, 1.0, 1.0, np.inf])
    second = np.array([2.0, 3.0, 4.0, 5.0, 6.0, np.inf, np.inf])
    assert paired.signed_rank(first, second) == pytest.approx(2.0 / 2**6)
    assert paired.signed_rank(first, first) == 1.0


def test_holm_steps_down():
    assert paired.holm([0.01, 0.04, 0.03]).tolist() == pytest.approx([0.03, 0.06, 0.06])
    assert paired.holm([0.9, 0.8]).max() == 1.0


def test_friedman_is_that_of_scipy(rng):
    errors = rng.lognormal(size=(12, 4)) * [1.0, 1.5, 2.0, 2.0]
    assert paired.friedman(errors) == pytest.approx(friedmanchisquare(*errors.T).pvalue)
    assert math.isnan(paired.friedman(errors[:, :2])) and paired.friedman(np.ones((5, 3))) == 1.0


def test_critical_difference_is_that_of_demsar():
    """Demsar 2006, section 3.2.2: four classifiers, 14 data sets, q = 2.569."""
    assert paired.critical_difference(14, 4) == pytest.approx(2.569 * math.sqrt(4 * 5 / (6 * 14)), rel=1e-3)


def test_groups_join_neighbours_that_no_test_tells_apart(rng):
    scale = np.exp(rng.normal(scale=0.05, size=(20, 4)))
    found = paired.compare(scale * [1.0, 1.0, 3.0, 9.0], ["a", "b", "c", "d"])
    assert set(found.methods[:2]) == {"a", "b"} and found.methods[2:] == ("c", "d")
    assert found.groups in {((0, 1),), ()} and found.p[1, 3] < 1e-3 and found.friedman_p < 1e-6


def test_profiles_count_problems_within_a_factor_of_the_least_error():
    errors = np.array([[1.0, 2.0], [3.0, 1.0], [1.0, np.inf]])
    found = profiles.performance_profiles(errors, np.array([1.0, 2.0, 3.0]))
    assert found.tolist() == [[2 / 3, 1 / 3], [2 / 3, 2 / 3], [1.0, 2 / 3]]


def test_the_front_has_what_nothing_beats_in_error_and_time():
    assert profiles.pareto([1.0, 2.0, 0.5, np.inf, 0.6], [2.0, 1.0, 9.0, 0.1, 9.5]) == [1, 0, 2]


def test_seeds_needed_follow_from_the_spread_between_seeds(rng):
    runs = np.exp(rng.normal(scale=0.2, size=(40, 5, 4)))
    found = profiles.seeds_needed(runs, (0.1, 0.5))
    assert found.spread == pytest.approx(0.2, rel=0.25) and found.seeds == 4
    z = 1.959964 + 0.841621
    assert found.needed == {d: math.ceil(2 * (z * found.spread / math.log1p(d)) ** 2) for d in (0.1, 0.5)}


def test_the_floor_is_the_median_error_at_the_bound(run_of, parameter_of):
    runs = [
        run_of(error=e, noise=n, method=m, parameters=[parameter_of("K", 2.0, 2.0 * (1 + e), sd)])
        for n, e, sd in (("low", 0.02, 0.1), ("high", 0.1, 0.4))
        for m in "ab"
    ]
    results, estimates = tables_of(runs)
    cells = standings.cell_table(standings.judged(results, estimates))
    curves, floor = profiles.noise_curves(cells, estimates, ["a"])
    assert curves == {"a": pytest.approx({"low": 0.02, "high": 0.1})}
    assert floor == pytest.approx({"low": 0.6745 * 0.05, "high": 0.6745 * 0.2})


def test_the_answer_names_the_best_and_who_is_as_good(board_of, eight_problems):
    board = board_of(eight_problems)
    assert [place.method for place in board.order()][-1] == "c"
    told = answer(board)
    assert ("c" not in told.split("(")[0] and "is as good (p" in told) or "no other is as good" in told
    assert "too few for a test" in answer(board.where({"vessel": "v0", "noise": "low"}))


def test_a_difference_that_no_test_shows_is_not_called_one(board_of, run_of):
    ratios = (3.0, 0.5, 3.0, 0.4, 3.0, 3.0)
    runs = [
        run_of(r2=1.0 - (0.01 * factor) ** 2, method=m, vessel=f"v{p}")
        for p, ratio in enumerate(ratios)
        for m, factor in (("a", 1.0), ("b", ratio))
    ]
    assert "b errs 3.0 times as much, but no test tells the two apart (p = " in answer(board_of(runs))


def test_a_budget_ranks_slow_methods_last(board_of, eight_problems):
    board = board_of(eight_problems).where(budget_s=2.0)
    place = {place.method: place for place in board.order()}
    assert place["a"].mean_rank == 3.0 and place["a"].imputed == 8 and place["c"].mean_rank == 2.0


def test_nothing_is_chosen_where_nothing_was_run(board_of, eight_problems):
    board = board_of(eight_problems)
    assert answer(board.where({"vessel": "none"})) == "No two methods were compared under these conditions."


def test_a_method_of_few_problems_stands_below_the_others(board_of, run_of, eight_problems):
    extra = run_of(r2=1.0, method="d", vessel="v0", noise="low", cpu_s=0.1)
    order = board_of([*eight_problems, extra]).order()
    assert order[-1].method == "d" and order[-1].partial and order[-1].mean_rank == 1.0


def test_the_ranking_is_that_of_the_standings(eight_problems, board_of):
    results, estimates = tables_of(eight_problems)
    order = [place.method for place in board_of(eight_problems).order()]
    assert standings.build(results, estimates).overall["method"].tolist() == order


def test_sensitivity_leaves_vessels_out_and_takes_other_metrics(run_of, rng):
    results, estimates = tables_of(problems(run_of, rng, 1.2))
    judged = standings.judged(results, estimates)
    cells = standings.cell_table(judged)
    board = contest.contest(cells, judged)
    found = {row.choice: row for row in profiles.sensitivity(board, profiles.other_metrics(cells, board))}
    assert set(found) >= {"by heading RMSE", "without v0", "without v3"} and "by time" not in found
    assert found["without v0"].first == "a" and found["without v0"].problems == 6


@pytest.mark.parametrize(
    ("train", "text"),
    [
        ("zigzag:10/10+zigzag:10/10:port", "zigzag 10/10"),
        ("zigzag:10/10+zigzag:20/20+turn:25", "turns and zigzags"),
        ("sine:15deg/60s+5deg/20s", "sine 15deg/60s+5deg/20s"),
        ("zigzag:20/20@euler", "zigzag 20/20, Euler steps"),
        ("Z_15_05", "Z_15_05"),
    ],
)
def test_excitations_in_words(train, text):
    assert contest.excitation(train) == text
