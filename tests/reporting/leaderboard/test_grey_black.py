"""The best grey box against the best black box, from a contest."""

import numpy as np
import pandas as pd
import pytest

from helmbench.reporting.leaderboard.contest import Contest
from helmbench.reporting.leaderboard.findings import grey_against_black, grey_black_sentence, kinds_of


def board(errors):
    """A contest of methods with errors (P,) each."""
    table = np.column_stack([*errors.values()])
    none = np.zeros((*table.shape, 3), dtype=int)
    problems = pd.DataFrame({"vessel": np.arange(len(table))})
    return Contest(tuple(errors), problems, table, table[:, :, None], table, none, "prediction")


def made_up(rng, factor=0.5, count=12):
    black = rng.uniform(1.0, 2.0, count)
    return {
        "gp-narx": black,
        "arx": 3.0 * black,
        "pem": factor * black * rng.uniform(0.8, 1.2, count),
        "ls": 9.0 * black,
    }


def test_the_best_of_each_kind_are_compared_in_pairs(rng):
    found = grey_against_black(board(made_up(rng)))
    ratio, p = pytest.approx(2.0, rel=0.25), pytest.approx(2.0**-11)
    assert found == {"grey": "pem", "black": "gp-narx", "pairs": 12, "better": 12, "ratio": ratio, "p": p}
    turned = board(made_up(rng, factor=2.0))
    assert grey_against_black(turned)["better"] == 0
    assert "the black box beats the grey box" in grey_black_sentence(turned)


def test_a_tie_is_told(rng):
    errors = made_up(rng)
    errors["pem"] = errors["gp-narx"] * np.tile([0.9, 1.0 / 0.9], 6)
    assert grey_against_black(board(errors))["p"] > 0.05
    assert "no difference is shown" in grey_black_sentence(board(errors))


def test_a_problem_without_a_finite_error_counts_as_the_worst_and_one_without_a_run_not_at_all(rng):
    errors = made_up(rng)
    errors["pem"][:2] = np.inf
    assert grey_against_black(board(errors))["better"] == 10
    errors["gp-narx"][0] = np.inf  # neither: no pair
    found = grey_against_black(board(errors))
    assert (found["better"], found["pairs"]) == (10, 11)
    errors["pem"][2] = np.nan
    found = grey_against_black(board(errors))
    assert (found["better"], found["pairs"]) == (9, 10)


def test_too_few_problems_or_a_missing_kind_say_nothing(rng):
    assert grey_against_black(board(made_up(rng, count=5))) is None
    assert grey_against_black(board({name: e for name, e in made_up(rng).items() if name in ("pem", "ls")})) is None


def test_kinds_are_those_of_the_registry(rng):
    assert kinds_of(["ls,scheme=midpoint", "fw-rls (as_printed)", "mean", "sklearn:Ridge", "no-such"]) == {
        "ls,scheme=midpoint": "grey box",
        "fw-rls (as_printed)": "grey box",
        "mean": "floor",
        "sklearn:Ridge": "black box",
    }
    told = grey_black_sentence(board(made_up(rng)), "At sea")
    assert told.startswith("At sea, in free runs the grey box beats the black box: pem (best") and "12 of 12" in told
