"""Statistics of the leaderboard, against scipy, published examples and cases small enough for the hand."""

import math
from itertools import product

import numpy as np
import pytest
from scipy.stats import wilcoxon

from helmbench.bench.kinds import IDENTIFICATION, kind_of
from helmbench.bench.store import frames
from helmbench.reporting.leaderboard import contest, equivalence
from helmbench.reporting.leaderboard.answer import answer, stability
from helmbench.reporting.leaderboard.board import build


@pytest.fixture
def board_of():
    """The contest of stored runs."""

    def contest_of(runs, criterion="prediction"):
        board = leaderboard_of(runs)
        return contest.contest(board.cells, board.runs, criterion)

    return contest_of


def leaderboard_of(runs):
    return build(*frames(runs, kind_of(IDENTIFICATION).tables))


@pytest.fixture
def eight_problems(run_of, rng):
    """Three methods on eight problems and two seeds: `a` is best and slow, `b` nearly as good and quick, `c` worse."""
    return problems(run_of, rng, 1.01)


def problems(run_of, rng, second, ships=4):
    """Three methods on eight problems and two seeds: `a` is best and slow, `b` errs `second` times as much, `c` four
    times."""
    factors = {"a": (1.0, 3.0), "b": (second, 1.0), "c": (4.0, 0.5)}
    spread = {key: rng.normal(scale=0.02) for key in product("abc", range(8), range(2))}
    return [
        run_of(
            r2=1.0 - (0.01 * (p + 1) * factor * math.exp(spread[m, p, s])) ** 2,
            method=m, vessel=f"v{p * ships // 8}", noise=("low", "medium")[p % 2], seed=s, cpu_s=seconds,
        )
        for m, (factor, seconds) in factors.items()
        for p, s in product(range(8), range(2))
    ]  # fmt: skip


def test_signed_ranks_are_those_of_scipy(rng):
    for n in (6, 12, 40, 80):
        first, second = rng.lognormal(size=(2, n))
        d = np.log(first / second)
        for way in ("two-sided", "less", "greater"):
            assert equivalence.signed_rank(d, way) == pytest.approx(wilcoxon(d, alternative=way).pvalue, rel=1e-6)


def test_infinite_errors_are_the_largest_and_equal_among_each_other():
    first = np.array([1.0, 1.0, 1.0, 1.0, 1.0, 1.0, np.inf])
    second = np.array([2.0, 3.0, 4.0, 5.0, 6.0, np.inf, np.inf])
    assert equivalence.signed_rank(equivalence.log_ratios(first, second)) == pytest.approx(2.0 / 2**6)
    assert equivalence.signed_rank(equivalence.log_ratios(first, first)) == 1.0


def test_holm_steps_down():
    assert equivalence.holm([0.01, 0.04, 0.03]).tolist() == pytest.approx([0.03, 0.06, 0.06])
    assert equivalence.holm([0.9, 0.8]).max() == 1.0


TRUTHS = [(1.0, equivalence.EQUAL), (1.1, equivalence.EQUAL), (2.0, equivalence.WORSE), (440.0, equivalence.WORSE)]


@pytest.mark.parametrize(("ratio", "verdict"), TRUTHS)
@pytest.mark.parametrize("spread", [lambda p: f"v{p}", lambda p: f"v{p // 6}", lambda p: "mariner"])
def test_verdicts_are_those_of_the_true_ratio(board_of, run_of, rng, ratio, verdict, spread):
    """Twelve ships, two ships of six problems each, one ship: log errors have a standard deviation of .01."""
    board = board_of(ratios_of(run_of, [ratio * math.exp(0.01 * rng.normal()) for _ in range(12)], spread))
    best = board.methods.index("a")
    found = equivalence.against(board, best, 1 - best)
    assert found.verdict == verdict and found.error_ratio == pytest.approx(ratio, rel=0.1)
    assert found.sample == ("12 ships" if len(set(board.problems["vessel"])) == 12 else "12 problems")


def ratios_of(run_of, ratios, ship):
    """A problem for every ratio of the errors b / a."""
    return [
        run_of(r2=1.0 - (0.001 * factor) ** 2, method=m, vessel=ship(p), train=f"zigzag:{p}/{p}")
        for p, ratio in enumerate(ratios)
        for m, factor in (("a", 1.0), ("b", ratio))
    ]


def test_many_problems_of_few_ships_are_not_many_ships(board_of, run_of):
    """As good on five ships of six in 20 problems each, three times worse on the sixth: its problems do not vanish."""
    ratios = [1.0 + 0.001 * p for p in range(20)] + [3.0 + 0.001 * p for p in range(5)]
    board = board_of(ratios_of(run_of, ratios, lambda p: f"v{p // 20}"))
    assert equivalence.against(board, 0, 1).verdict == equivalence.OPEN
    one = board.where({"vessel": "v0"})
    assert equivalence.against(one, 0, 1).verdict == equivalence.EQUAL


def test_nothing_is_called_equal_where_the_errors_shown_differ(board_of, run_of):
    """As good in 11 of 20 problems with tiny errors, 400 times worse in those that make the median."""
    errors = [(0.0011, 0.48 if p % 2 else 0.0011) for p in range(20)]
    runs = [
        run_of(r2=1.0 - e**2, method=m, vessel=f"v{p}")
        for p, pair in enumerate(errors)
        for m, e in zip("ab", pair, strict=True)
    ]
    told = answer(board_of(runs))
    assert "as good (" not in told


def test_a_small_board_says_that_it_has_too_few_problems(board_of, run_of):
    told = answer(board_of(ratios_of(run_of, [1.01] * 4, lambda p: f"v{p}")))
    figures = "a (error 0.0010, 0.40 s; 4 problems of 4 ships)"
    few = "too few problems (4 problems) to say which are as good; the nearest, b errs 1.0 times as much."
    assert told == f"{figures}; {few}"


def test_a_difference_that_is_not_shown_is_not_settled(board_of, run_of):
    told = answer(board_of(ratios_of(run_of, [3.0, 0.5, 3.0, 0.4, 3.0, 3.0], lambda p: f"v{p}")))
    sample = "6 ships, with which p is 0.016 at the least"
    assert f"none is shown to be as good, and it is not settled: b errs 3.0 times as much ({sample})" in told


def test_the_answer_names_the_best_those_as_good_and_the_fast_choice(board_of, run_of, rng):
    told = answer(board_of(problems(run_of, rng, 1.1, ships=8)))
    assert told.startswith("a (error") and "s; 8 problems of 8 ships)" in told
    sample = "8 ships, with which p is 0.0039 at the least"
    assert f"as good (error below 1.25 times, {sample}): b; fast choice: b, 3.0 " in told
    assert "c" not in told.split("): ")[1].split(";")[0]


@pytest.mark.parametrize(("groups", "least"), [([5], 0.5**5), ([6, 5], 0.5**5), ([12], 0.5**12)])
def test_no_sample_has_a_smaller_p_than_stated(board_of, run_of, groups, least):
    """Ratios that all lie on one side; two ships with problems of their own must both show it."""
    ships = [f"v{n}" for n, size in enumerate(groups) for _ in range(size)]
    alone = len(groups) == 1
    ratios = [1.01 + 0.001 * p for p in range(len(ships))]
    board = board_of(ratios_of(run_of, ratios, (lambda p: f"v{p}") if alone else ships.__getitem__))
    found = equivalence.against(board, 0, 1)
    assert found.least_p == least and found.p == pytest.approx(least)


def test_little_skill_is_said_with_what_the_floor_gets(board_of, run_of):
    def told(best):
        errors = {"pem": best, "mean": 1.1, "straight-line": 0.9}
        return answer(
            board_of([run_of(r2=1.0 - e**2, method=m, vessel=f"v{n}") for m, e in errors.items() for n in range(3)])
        )

    little = ", which is little skill: straight-line, without any identification, errs 0.90;"
    assert told(0.78).startswith(f"pem (error 0.78, 0.40 s; 3 problems of 3 ships){little}")
    assert "little skill" not in told(0.4)
    assert told(1.2).startswith("straight-line (error 0.90, 0.40 s; 3 problems of 3 ships), which identifies nothing;")


def test_what_is_known_of_the_ship_is_never_put_together(board_of, run_of):
    """Known equations: a is best; others: b. The answer has a line each, and the measured set's is its own."""
    runs = [
        run_of(error=0.1 if known else None, r2=1.0 - e**2, method=m, vessel=ship, train=f"zigzag:{p}/{p}", **model)
        for ship, model, known, errors in (
            ("mariner", {}, True, (0.001, 0.4)),
            ("mariner", {"model": "nomoto-1"}, False, (0.4, 0.2)),
            ("kvlcc2-hsva", {"model": "nomoto-1", "measured": True}, False, (0.3, 0.5)),
        )
        for m, e in zip("ab", errors, strict=True)
        for p in range(6)
    ]
    lines = answer(board_of(runs)).splitlines()
    assert [line.split(" (")[0] for line in lines] == [
        "Equations known: a",
        "Equations unknown: b",
        "Measured ships: a",
    ]


def test_stability_draws_ships(board_of, run_of, rng):
    board = board_of(problems(run_of, rng, 1.5, ships=8))
    assert stability(board) == ({"a": 1.0}, 8, (1, 1))
    split = board_of(ratios_of(run_of, [4.0, 4.0, 0.25, 0.25, 4.0], lambda p: f"v{p}"))
    assert 0.5 < stability(split)[0]["a"] < 1.0 and stability(split.where({"vessel": "v0"})) is None


def test_nothing_is_chosen_where_nothing_was_run(board_of, eight_problems):
    board = board_of(eight_problems)
    assert answer(board.where({"vessel": "none"})) == "No two methods were compared under these conditions."


def test_a_method_of_few_problems_stands_below_the_others(board_of, run_of, eight_problems):
    extra = run_of(r2=1.0, method="d", vessel="v0", noise="low", cpu_s=0.1)
    order = board_of([*eight_problems, extra]).order()
    assert order[-1].method == "d" and order[-1].partial and order[-1].mean_rank == 1.0


def test_the_ranking_is_that_of_the_standings(eight_problems, board_of):
    order = [place.method for place in board_of(eight_problems).order()]
    assert leaderboard_of(eight_problems).overall["method"].tolist() == order


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


@pytest.mark.parametrize(
    ("held_out", "text"),
    [
        ("turn:35+zigzag:30/30", "turns and zigzags"),
        ("zz_20+zz_10 (set kvlcc2-marin)", "zz_10, zz_20 (set kvlcc2-marin)"),
        ("turn:20 (noise high)", "turn 20 (noise high)"),
    ],
)
def test_predicted_records_in_words(held_out, text):
    assert contest.predicted(held_out) == text
