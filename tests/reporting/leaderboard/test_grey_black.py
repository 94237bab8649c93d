"""The best grey box against the best black box, from rows of results."""

import numpy as np
import pandas as pd
import pytest

from helmbench.reporting.leaderboard.grey_black import METRIC, grey_against_black, kinds_of
from helmbench.reporting.leaderboard.standings import CELL

KINDS = {"pem": "grey box", "ls": "grey box", "gp-narx": "black box", "arx": "black box"}


def table(errors, seeds=2):
    """Rows of every method with errors (conditions,)."""
    rows = [
        {**dict.fromkeys(CELL, "same"), "vessel": f"ship {place}", "method": method, "variant": "corrected"}
        | {"seed": seed, "status": "ok", "diverged": False, METRIC: value}
        for method, values in errors.items()
        for place, value in enumerate(values)
        for seed in range(seeds)
    ]
    return pd.DataFrame(rows)


def made_up(rng, factor=0.5, count=12):
    black = rng.uniform(1.0, 2.0, count)
    return {
        "gp-narx": black,
        "arx": 3.0 * black,
        "pem": factor * black * rng.uniform(0.8, 1.2, count),
        "ls": 9.0 * black,
    }


def test_the_best_of_each_kind_are_compared_in_pairs(rng):
    found = grey_against_black(table(made_up(rng)), KINDS)
    assert (found.grey, found.black, found.pairs, found.better) == ("pem", "gp-narx", 12, 12)
    assert found.ratio == pytest.approx(0.5, rel=0.2) and found.p == pytest.approx(2.0**-11)
    assert "the grey box beats the black box" in found.sentence() and "12 of 12" in found.sentence()
    turned = grey_against_black(table(made_up(rng, factor=2.0)), KINDS)
    assert turned.better == 0 and "the black box beats the grey box" in turned.sentence()


def test_a_tie_is_told(rng):
    errors = made_up(rng)
    errors["pem"] = errors["gp-narx"] * np.tile([0.9, 1.0 / 0.9], 6)
    found = grey_against_black(table(errors), KINDS)
    assert found.p > 0.05 and "no difference is shown" in found.sentence()


def test_a_run_that_fails_or_diverges_counts_as_the_worst(rng):
    rows = table(made_up(rng), seeds=1)
    lost = (rows["method"] == "pem") & rows["vessel"].isin(["ship 0", "ship 1"])
    rows.loc[lost, ["status", METRIC]] = ["failed", np.nan]
    assert grey_against_black(rows, KINDS).better == 10
    rows.loc[(rows["method"] == "gp-narx") & (rows["vessel"] == "ship 2"), "diverged"] = True
    assert grey_against_black(rows, KINDS).better == 10


def test_too_few_conditions_or_a_missing_kind_say_nothing(rng):
    assert grey_against_black(table(made_up(rng, count=5)), KINDS) is None
    assert grey_against_black(table(made_up(rng)), {"pem": "grey box"}) is None


def test_kinds_are_those_of_the_registry():
    assert kinds_of(["ls,scheme=midpoint", "mean", "sklearn:Ridge", "no-such"]) == {
        "ls,scheme=midpoint": "grey box",
        "mean": "floor",
        "sklearn:Ridge": "black box",
    }
