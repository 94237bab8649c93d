"""The test of the advice: situations, the page's rule, and the regret, on made-up results where the best is known."""

import math

import numpy as np
import pytest

from helmbench import check_advice
from helmbench.bench.kinds import IDENTIFICATION, kind_of
from helmbench.bench.kinds.base import RunSelection
from helmbench.bench.kinds.identification.plan import plan
from helmbench.bench.situations import SEEDS, Situation, checks_text, draw, suite_text
from helmbench.bench.store import Store, frames
from helmbench.bench.suites import load_suite
from helmbench.models.errors import BadInput
from helmbench.reporting.leaderboard import advice
from helmbench.reporting.leaderboard.answer import answer, shortlist
from helmbench.reporting.leaderboard.board import build

SHIPS = ("mariner", "s175", "kvlcc2-l7")
CALM, WINDY = {}, {"disturbance": "wind:8@40deg"}


def board_of(runs):
    results, parameters = frames(runs, kind_of(IDENTIFICATION).tables)
    return build(results, parameters).contest


@pytest.fixture
def calm_and_windy(run_of):
    """In calm water `a` is best on every ship, in wind `b`; `c` is better than both but seldom applies."""
    errors = {("a", False): 0.02, ("b", False): 0.1, ("a", True): 0.5, ("b", True): 0.1}
    return [
        run_of(error=0.1, r2=1.0 - e**2, method=m, vessel=ship, **(WINDY if windy else CALM))
        for (m, windy), e in errors.items()
        for ship in SHIPS
    ]


def test_the_advice_is_that_of_the_conditions(calm_and_windy):
    board = board_of(calm_and_windy)
    known = {"case": "equations known", "noise": "low", "model": "abkowitz"}
    calm = advice.advise(board, known | {"disturbance": "none"}, ["a", "b"])
    windy = advice.advise(board, known | {"disturbance": "wind:5@200deg"}, ["a", "b"])
    assert (calm.method, windy.method) == ("a", "b") and windy.chosen["disturbance"] == "wind:8@40deg"
    assert advice.advise(board, known | {"disturbance": "none"}, ["b"]).method == "b"
    assert advice.advise(board, {"case": "measured ships"}, ["a"]) is None


def test_where_equations_are_unknown_the_advice_is_the_plain_rule(run_of):
    """The board ranks grey-gp first; its list begins with that."""
    errors, unknown = {"output-error": 0.2, "grey-gp": 0.1}, {"error": None, "model": "nomoto-1", "parameters": []}
    board = board_of([run_of(r2=1.0 - e**2, method=m, vessel=v, **unknown) for m, e in errors.items() for v in SHIPS])
    wanted = {"case": "equations unknown", "model": "nomoto-1"}
    found = advice.advise(board, wanted, ["output-error", "grey-gp"])
    assert found.method == advice.UNKNOWN and found.listed[0] == "grey-gp"
    assert advice.advise(board, wanted, ["grey-gp"]).method == "grey-gp"


@pytest.mark.parametrize(
    ("text", "level"),
    [
        ("wind:12@10deg", "wind:15@40deg"),
        ("wind:3@10deg", "wind:8@40deg"),
        ("current:0.2@0deg", None),
        ("none", "none"),
    ],
)
def test_the_nearest_level_is_of_the_same_kind(text, level):
    assert advice.nearest(["none", "wind:8@40deg", "wind:15@40deg"], text) == level


def test_channels_that_are_missing_count_before_the_size_of_the_noise():
    levels = ["low", "high", "low,only=heading"]
    assert advice.nearest(levels, "high,only=heading") == "low,only=heading" and advice.nearest(levels, "gross") is None


def situation(disturbance="none"):
    return Situation("cargo", "own", ("zigzag:20/20",), ("turn:35",), "low", disturbance, "zigzag:15/15")


def runs_of(run_of, errors, **facts):
    """Runs of cargo with the error of each (method, disturbance)."""
    return [
        run_of(error=0.1, r2=1.0 - e**2, method=m, vessel="cargo", model="nomoto-2", disturbance=d, **facts)
        for (m, d), e in errors.items()
    ]


def test_regret_is_the_ratio_of_the_errors(calm_and_windy, run_of):
    windy, calm = situation("wind:9@0deg"), situation()
    errors = {("a", "none"): 0.3, ("b", "none"): 0.1, ("a", "wind:9@0deg"): 0.4, ("b", "wind:9@0deg"): 0.2}
    fresh = board_of(runs_of(run_of, errors))
    checks = board_of(runs_of(run_of, {("a", "none"): 0.1, ("b", "none"): 0.2}, held_out="zigzag:15/15"))
    advised = advice.advices(board_of(calm_and_windy), fresh, [windy, calm])
    assert {one.method for one in advised.values()} == {"a", "b"}
    found = advice.tested(advised, fresh, checks)
    assert [one.advice.method for one in found] == ["b", "a"]
    assert [one.regret for one in found] == pytest.approx([1.0, 3.0], rel=1e-3)
    told = advice.report(found, len(found) + 1, 7)
    assert "in 50 % [" in advice.summary(found) and "Own equations, 2 situations: the advice 50 % [" in advice.summary(
        found
    )
    assert "own equations, disturbed" in told
    assert "3 situations were drawn with seed 7; in 1 no method applies" in told
    lost = advice.Tested(calm, found[0].advice, math.inf, math.inf, "b", 0.001)
    small = advice.Tested(calm, found[0].advice, 0.009, 0.3, "b", 0.001)
    assert small.regret_without_floor == pytest.approx(9.0) and lost.regret_without_floor == math.inf
    assert "Without the floor, below which errors count as 0.01, it does so in 0 % [" in advice.summary([small])
    assert "without the floor" in told
    assert lost.regret == math.inf and small.regret == 1.0 and small.chosen_regret == pytest.approx(30.0)


def test_plain_rules_stand_beside_the_advice(calm_and_windy, run_of):
    """`output-error` is best in calm water, where the board names `a`; it does not apply in wind."""
    windy, calm = situation("wind:9@0deg"), situation()
    errors = {("a", "none"): 0.3, ("output-error", "none"): 0.1, ("grey-gp", "none"): 0.2, ("a", "wind:9@0deg"): 0.4}
    fresh = board_of([*runs_of(run_of, errors), *runs_of(run_of, {("b", "wind:9@0deg"): 0.2})])
    found = advice.tested(advice.advices(board_of(calm_and_windy), fresh, [calm, windy]), fresh, fresh)
    regrets = [[one.regret, *map(one.plain_regret, advice.PLAIN_RULES)] for one in found]
    assert regrets[0] == pytest.approx([3.0, 1.0, 2.0], rel=1e-3) and regrets[1] == [1.0, math.inf, math.inf]
    told = advice.summary(found)
    assert "Own equations, 2 situations: the advice 50 % [" in told
    assert "always output-error 50 % [" in told and "always grey-gp 0 % [" in told


def test_known_particulars_are_the_advice_where_equations_are_unknown(run_of):
    """Of two ships with other equations the particulars of one are known; their simulation is best there in the median.

    The board's rule, `output-error`, errs twice as much as the best method on the other."""
    facts = {"error": None, "parameters": [], "vessel": "kvlcc2-l7", "model": "nomoto-1"}
    one, other = (
        Situation("kvlcc2-l7", "nomoto-1", ("zigzag:20/20",), ("turn:35",), noise, "none", "turn:20")
        for noise in ("low", "high")
    )
    errors = {"output-error": 0.4, "grey-gp": 0.2}
    fresh = board_of(
        [run_of(r2=1.0 - e**2, method=m, noise=n, **facts) for m, e in errors.items() for n in ("low", "high")]
    )
    advised = {place: advice.Advice("output-error", ("grey-gp",), {}) for place in (one, other)}
    found = advice.tested(advised, fresh, fresh, {one: [0.1, 0.05, math.inf]})
    assert [(found[0].advice.method, found[0].best), found[1].advice.method] == [
        (advice.PARTICULARS, advice.PARTICULARS),
        "output-error",
    ]
    assert [t.regret for t in found] == pytest.approx([1.0, 2.0], rel=1e-3) and found[0].least == pytest.approx(0.1)
    assert found[0].plain_regret("output-error") == pytest.approx(4.0, rel=1e-3)
    told = advice.summary(found)
    assert "Other equations and known particulars (the advice is particulars, corrected), 1 situations: the ad" in told
    assert "Other equations (the advice is output-error, whatever ranks first), 1 situations: the advice 0 %" in told
    assert "particulars, corrected (0.1)" in advice.report(found, 2, 7)


def test_of_a_list_the_method_is_taken_that_errs_least_on_the_check_record(run_of):
    """`b` errs less on what is predicted in both draws of the noise; the record to choose by says so in the second."""
    one, found = situation(), advice.Advice("a", ("a", "b", "unknown"), {})
    fresh, checks = (
        board_of(
            [
                run_of(
                    error=0.1, r2=1.0 - e**2, method=m, vessel="cargo", model="nomoto-2", held_out=held_out, seed=seed
                )
                for m, errors in table.items()
                for seed, e in enumerate(errors)
            ]
        )
        for held_out, table in (
            ("turn:35", {"a": (0.4, 0.4), "b": (0.1, 0.2)}),
            ("zigzag:15/15", {"a": (0.2, 0.3), "b": (0.5, 0.1)}),
        )
    )
    (tested,) = advice.tested({one: found}, fresh, checks)
    assert tested.error == pytest.approx(0.4, rel=1e-3) and tested.chosen_error == pytest.approx(0.3, rel=1e-3)
    other = situation("wind:8@0deg")
    assert advice.tested({one: advice.Advice("a", ("a",), {})}, fresh, board_of(runs_of(run_of, {("a", "none"): 0.1})))
    assert advice.advices(fresh, fresh, [other]) == {}


def board_of_ships(run_of, errors, ships):
    """A board with the error of each method on each ship."""
    return board_of(
        [
            run_of(error=0.1, r2=1.0 - e**2, method=m, vessel=ship)
            for m, row in errors.items()
            for ship, e in zip(ships, row, strict=True)
        ]
    )


def test_a_short_list_covers_the_problems_with_few_methods(run_of):
    """`a` is good on four ships, `b` and `c` on two each, `d` on none that these leave."""
    errors = {
        "a": (0.1, 0.1, 0.1, 0.1, 0.9, 0.9, 0.9, 0.9),
        "b": (0.5, 0.5, 0.5, 0.5, 0.1, 0.1, 0.9, 0.9),
        "c": (0.5, 0.5, 0.5, 0.5, 0.9, 0.9, 0.1, 0.1),
        "d": (0.11, 0.5, 0.5, 0.5, 0.9, 0.9, 0.9, 0.9),
    }
    ships = ("cargo", "mariner", "s175", "patrol", "remus", "response-1", "kvlcc2-l7", "remus-kt")
    board = board_of_ships(run_of, errors, ships)
    assert shortlist(board, ["a", "d", "c", "b"]) == (["a", "c", "b"], 1.0, 8)
    assert shortlist(board, ["d", "a"]) == (["d", "a"], 0.5, 8)
    assert "Compare a, b, c on a record kept back" in answer(board) and "100 % of 8 problems" in answer(board)


def test_a_short_list_is_worth_what_it_is_on_a_ship_left_out(run_of):
    """Each ship has a best method of its own: no list that others make holds it, though all problems are covered."""
    ships = ("cargo", "mariner", "s175", "patrol", "remus", "response-1", "kvlcc2-l7")
    errors = {name: tuple(0.1 if i == j else 0.5 for j in range(7)) for i, name in enumerate("abcdefg")}
    errors["none"] = (0.9,) * 7
    board = board_of_ships(run_of, {name: (*row, 1.1) for name, row in errors.items()}, (*ships, "remus-kt"))
    assert shortlist(board, ["none", *"abcdefg"]) == (["none"], 0.0, 7)  # nobody predicts the eighth
    shared = [
        (m, s, e) for m, row in {"a": (0.1, 0.1), "b": (0.5, 0.5)}.items() for s, e in zip(ships, row, strict=False)
    ]
    alone = [("b", ships[2], 0.01), ("b", ships[3], 0.01)]
    board = board_of([run_of(error=0.1, r2=1.0 - e**2, method=m, vessel=s) for m, s, e in shared + alone])
    assert shortlist(board, ["a", "b"]) == (["a"], 1.0, 2)  # `b` alone was run on two ships
    one = board_of_ships(run_of, {"a": (0.1,), "b": (0.5,)}, ("cargo",))
    assert shortlist(one, ["b", "a"])[0] == ["b", "a"] and np.isnan(shortlist(one, ["b", "a"])[1])
    assert "Compare" not in answer(one)


def test_drawn_situations_can_be_planned_and_do_not_depend_on_their_number(tmp_path, seed):
    drawn = draw(60, seed)
    assert draw(7, seed) == drawn[:7] and draw(7, seed + 1) != drawn[:7]
    path = tmp_path / "situations.yaml"
    path.write_text(suite_text(drawn, ["ls"]))
    specs = plan(load_suite(str(path)), RunSelection("situations"))
    assert len(specs) == SEEDS * len(set(drawn))
    assert all(not set(one.train) & {*one.held_out, one.check} and one.check not in one.held_out for one in drawn)
    path.write_text(checks_text({one: ["ls"] for one in drawn}))
    assert {spec.task.held_out_noise for spec in plan(load_suite(str(path)), RunSelection("checks"))} > {"low"}


@pytest.mark.nightly
def test_an_advice_is_tested_and_goes_on_where_it_stopped(tmp_path, manifest, calm_and_windy):
    with Store.create(tmp_path / "board", manifest(len(calm_and_windy))) as store:
        for run in calm_and_windy:
            store.append(run)
        store.write_tables()
    asked = {"directory": tmp_path / "out", "situations": 2, "methods": ("mean", "straight-line"), "jobs": 1}
    found = check_advice(tmp_path / "board", **asked)
    assert found.summary() in (tmp_path / "out" / "advice.md").read_text()
    stored = (tmp_path / "out" / "runs" / "runs.jsonl").read_bytes()
    again = check_advice(tmp_path / "board", **asked)
    assert again.rows == found.rows and (tmp_path / "out" / "runs" / "runs.jsonl").read_bytes() == stored
    with pytest.raises(BadInput, match="other situations"):
        check_advice(tmp_path / "board", **asked | {"seed": 1})
