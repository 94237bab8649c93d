"""The best grey box against the best black box, from a contest."""

import numpy as np
import pandas as pd
import pytest

from helmbench.reporting.leaderboard.contest import Contest
from helmbench.reporting.leaderboard.grey_black import grey_against_black, kinds_of

KINDS = {"pem": "grey box", "ls": "grey box", "gp-narx": "black box", "arx": "black box"}


def board(errors):
    """A contest of methods with errors (P,) each."""
    table = np.column_stack([*errors.values()])
    none = np.zeros(table.shape, dtype=int)
    problems = pd.DataFrame({"vessel": np.arange(len(table))})
    return Contest(tuple(errors), problems, table, table[:, :, None], table, none, none, none, "prediction")


def made_up(rng, factor=0.5, count=12):
    black = rng.uniform(1.0, 2.0, count)
    return {
        "gp-narx": black,
        "arx": 3.0 * black,
        "pem": factor * black * rng.uniform(0.8, 1.2, count),
        "ls": 9.0 * black,
    }


def test_the_best_of_each_kind_are_compared_in_pairs(rng):
    found = grey_against_black(board(made_up(rng)), KINDS)
    assert (found.grey, found.black, found.pairs, found.better) == ("pem", "gp-narx", 12, 12)
    assert found.ratio == pytest.approx(2.0, rel=0.25) and found.p == pytest.approx(2.0**-11)
    assert "the grey box beats the black box" in found.sentence() and "12 of 12" in found.sentence()
    turned = grey_against_black(board(made_up(rng, factor=2.0)), KINDS)
    assert turned.better == 0 and "the black box beats the grey box" in turned.sentence()


def test_a_tie_is_told(rng):
    errors = made_up(rng)
    errors["pem"] = errors["gp-narx"] * np.tile([0.9, 1.0 / 0.9], 6)
    found = grey_against_black(board(errors), KINDS)
    assert found.p > 0.05 and "no difference is shown" in found.sentence()


def test_a_problem_without_a_finite_error_counts_as_the_worst_and_one_without_a_run_not_at_all(rng):
    errors = made_up(rng)
    errors["pem"][:2] = np.inf
    assert grey_against_black(board(errors), KINDS).better == 10
    errors["gp-narx"][0] = np.inf  # neither: no pair
    found = grey_against_black(board(errors), KINDS)
    assert (found.better, found.pairs) == (10, 11)
    errors["pem"][2] = np.nan
    found = grey_against_black(board(errors), KINDS)
    assert (found.better, found.pairs) == (9, 10)


def test_too_few_problems_or_a_missing_kind_say_nothing(rng):
    assert grey_against_black(board(made_up(rng, count=5)), KINDS) is None
    assert grey_against_black(board(made_up(rng)), {"pem": "grey box"}) is None


def test_kinds_are_those_of_the_registry(rng):
    assert kinds_of(["ls,scheme=midpoint", "fw-rls (as_printed)", "mean", "sklearn:Ridge", "no-such"]) == {
        "ls,scheme=midpoint": "grey box",
        "fw-rls (as_printed)": "grey box",
        "mean": "floor",
        "sklearn:Ridge": "black box",
    }
    assert grey_against_black(board(made_up(rng))).grey == "pem"
