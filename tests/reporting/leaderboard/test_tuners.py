"""Tuners at equal budgets: what labels say, the tests over problems and methods, the sentence, the published page."""

import re

import numpy as np
import pandas as pd
import pytest

from helmbench.bench.kinds.identification.plan import plan
from helmbench.bench.store import read_tables
from helmbench.bench.suites import load_suite
from helmbench.estimation.methods_only.tuning.space import Choice, grid_of
from helmbench.estimation.methods_only.tuning.tune import TUNERS
from helmbench.methods.registry import make
from helmbench.reporting.leaderboard import publish
from helmbench.reporting.leaderboard.contest import Contest
from helmbench.reporting.leaderboard.page import write_report
from helmbench.reporting.leaderboard.tuners import budgets, excess, tuned, tuner_table

COMPARED = ("abc", "tpe", "cmaes", "random", "grid")


def board(errors):
    """A contest of labels with errors (P,) each."""
    table = np.column_stack([*errors.values()])
    none = np.zeros((*table.shape, 3), dtype=int)
    problems = pd.DataFrame({"vessel": np.arange(len(table))})
    return Contest(tuple(errors), problems, table, table[:, :, None], table, none, "prediction")


def made_up(rng, factors, trials=25, methods=("fw-rls", "rts-ls,level=2"), count=12):
    """Errors of every method and tuner with three seeds each, of which the middle one is the tuner's factor."""
    found = {}
    for method in methods:
        least = rng.uniform(1.0, 2.0, count)
        for tuner, factor in factors.items():
            for seed, luck in enumerate((0.5, 1.0, 3.0)):
                name, _, given = method.partition(",")
                options = [f"tuner={tuner}", f"trials={trials}", f"tuner_seed={seed}", *([given] if given else [])]
                found[",".join([f"tuned:{name}", *options])] = factor * luck * least
    return found


@pytest.mark.parametrize(
    ("label", "expected"),
    [
        ("tuned:fw-rls,tuner=abc,trials=25,tuner_seed=2", ("fw-rls", "abc", 25)),
        ("tuned:kernel-ridge,stride=4,tuner=grid,trials=64", ("kernel-ridge,stride=4", "grid", 64)),
        ("tuned:sklearn:SVR,epsilon=0.1,trials=9,tuner=tpe", ("sklearn:SVR,epsilon=0.1", "tpe", 9)),
        ("tuned:rts-ls,trials=12", None),
        ("tuned:rts-ls,tuner=abc", None),
        ("mlp,tuner=abc,trials=40", None),
        ("ls", None),
    ],
)
def test_what_a_label_says(label, expected):
    assert tuned(label) == expected


def test_the_median_seed_of_every_tuner_is_compared_over_problems_and_methods(rng):
    factors = {"abc": 1.2, "tpe": 1.0, "random": 1.5}
    (found,) = budgets(board(made_up(rng, factors)))
    assert (found.trials, found.methods, len(found.errors["abc"])) == (25, ("fw-rls", "rts-ls,level=2"), 24)
    assert list(found.errors) == ["tpe", "abc", "random"]
    assert {tuner: excess(found.errors, tuner) for tuner in factors} == pytest.approx(factors)
    text = found.sentence()
    assert "equal budgets (25 trials), tpe finds options with the least held-out error in the median" in text
    assert "signed ranks over 24 problems of 2 methods tell apart from it: abc, random." in text


def test_equal_tuners_are_not_told_apart(rng):
    """Three orders that occur equally often: no mean rank differs from another."""
    errors = made_up(rng, {"abc": 1.0, "tpe": 1.0, "grid": 1.0})
    turns = {"abc": [1.0, 1.1, 1.2], "tpe": [1.1, 1.2, 1.0], "grid": [1.2, 1.0, 1.1]}
    errors = {label: own * np.tile(turns[tuned(label)[1]], 4) for label, own in errors.items()}
    (found,) = budgets(board(errors))
    assert found.sentence().endswith("tell apart from it: none.")


def test_large_errors_of_a_few_problems_do_not_decide(rng):
    """The tuner that is best in every problem but those in the middle of all errors."""
    errors = made_up(rng, {"abc": 1.0, "tpe": 1.0, "random": 1.5}, methods=("fw-rls",), count=9)
    size = np.array([1.0, 1.0, 1.0, 1.0, 10.0, 100.0, 100.0, 100.0, 100.0])
    for label, own in errors.items():
        own *= size * (np.where(size == 10.0, 2.0, 0.9) if "tpe" in label else 1.0)
    (found,) = budgets(board(errors))
    assert next(iter(found.errors)) == "tpe" and excess(found.errors, "tpe") == 1.0
    assert np.median(found.errors["tpe"]) > np.median(found.errors["abc"])


def test_every_budget_is_a_comparison_of_its_own(rng):
    few, many = (made_up(rng, factors, trials) for factors, trials in (
        ({"abc": 1.0, "tpe": 2.0, "grid": 3.0}, 25), ({"abc": 3.0, "tpe": 2.0, "grid": 1.0}, 64),
    ))  # fmt: skip
    own = board(few | many)
    assert [(found.trials, next(iter(found.errors))) for found in budgets(own)] == [(25, "abc"), (64, "grid")]
    rows = tuner_table(own).rows
    assert [(row[0].text, row[1].text) for row in rows] == [
        ("25", "abc"), ("25", "tpe"), ("25", "grid"), ("64", "grid"), ("64", "tpe"), ("64", "abc"),
    ]  # fmt: skip


def test_failures_rank_last_and_problems_that_one_tuner_lacks_are_left_out(rng):
    errors = made_up(rng, {"abc": 1.0, "tpe": 2.0, "random": 3.0}, methods=("fw-rls",))
    for label, own in errors.items():
        if "abc" in label:
            own[:2] = np.inf  # worse than the others in two problems
            own[2] = np.nan
        own[3] = np.inf  # of all: says nothing
    (found,) = budgets(board(errors))
    assert len(found.errors["abc"]) == 10 and np.isinf(found.errors["abc"]).sum() == 2
    assert list(found.errors) == ["abc", "tpe", "random"]


def test_too_few_tuners_or_problems_say_nothing(rng):
    factors = {"abc": 1.0, "tpe": 2.0, "random": 3.0}
    assert budgets(board(made_up(rng, {"abc": 1.0, "tpe": 2.0}))) == []
    assert budgets(board(made_up(rng, factors, methods=("fw-rls",), count=5))) == []
    assert budgets(board({"ls": np.ones(9), "tuned:rts-ls,trials=12": np.ones(9)})) == []
    assert tuner_table(board({"ls": np.ones(9)})).rows == ()


def test_the_suite_gives_every_tuner_the_same_budget():
    """Numbers only, at least two (which CMA-ES needs), and grids that have as many points as there are trials."""
    found = {}
    for spec in plan(load_suite("tuners")):
        method, tuner, trials = tuned(spec.method)
        found.setdefault((method, trials), {}).setdefault(tuner, set()).add(spec.maker)
    assert len(found) == 6 and {trials for _, trials in found} == {25, 64}
    for (_, trials), by_tuner in found.items():
        assert set(by_tuner) == set(COMPARED) <= set(TUNERS)
        assert {tuner: len(makers) for tuner, makers in by_tuner.items()} == dict.fromkeys(COMPARED, 3) | {"grid": 1}
        space = make(min(by_tuner["grid"])).space
        assert len(space) == 2 and not any(isinstance(domain, Choice) for domain in space.values())
        assert np.prod([len(values) for values in grid_of(space, trials).values()]) == trials


@pytest.fixture
def folders(folder_of, run_of):
    """Results of a main suite, and of tuners on two of its problems and on others."""
    vessels = ("cargo", "mariner", "s175", "patrol", "remus-kt", "response-1")
    main = [
        run_of(error=e, r2=1.0 - e**2, method=method, vessel=vessel, suite="default")
        for method, e in (("pem", 0.1), ("ls", 0.2))
        for vessel in vessels[:3]
    ]
    tuning = [
        run_of(r2=1.0 - e**2, method=f"tuned:fw-rls,tuner={tuner},trials=25", vessel=vessel, suite="tuners")
        for tuner, e in (("abc", 0.03), ("tpe", 0.01), ("random", 0.02))
        for vessel in vessels
    ]
    return folder_of("default", main), folder_of("tuners", tuning)


def test_published_tuners_are_a_finding_and_no_part_of_the_ranking(folders, tmp_path):
    publish.publish(folders, tmp_path)
    readme, page = ((tmp_path / name).read_text() for name in (publish.README, publish.PAGE))
    assert "(25 trials), tpe finds options with the least held-out error in the median: 1 times the least" in readme
    assert "in the same problem (random 2, abc 3)" in readme
    assert "`helmbench run --suite tuners -o out/tuners`" in readme and "## Tuners at equal budgets" in readme
    ranking = re.search(r"## Ranking.*?\n(\|.*?)\n\n", readme, re.DOTALL)[1]
    assert [line.split("|")[1].strip() for line in ranking.splitlines()[2:]] == ["pem", "ls"]
    assert "tuned:fw-rls" not in page and "pem" in page
    again = {path.name: path.read_text() for path in publish.publish_again(tmp_path)}
    assert again[publish.README] == readme


def test_without_another_suite_the_tuned_methods_are_ranked(folders):
    results, _ = read_tables(folders[1])
    ranked, tuning = publish.ranked_and_tuning(results)
    assert len(ranked) == 18 and tuning is None


def test_a_report_of_the_suite_alone_has_sentence_and_table(folders):
    text = write_report(folders[1]).markdown
    page = (folders[1] / "leaderboard.html").read_text()
    for own in (text, page):
        assert "tpe finds options with the least held-out error" in own and "Tuners at equal budgets" in own
