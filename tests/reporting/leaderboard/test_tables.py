"""The table of stated uncertainties: medians of scores, means of shares, only methods that state one."""

import pandas as pd
import pytest

from helmbench.reporting.leaderboard.tables import uncertainty_finding, uncertainty_table


def runs(**columns):
    count = len(next(iter(columns.values())))
    return pd.DataFrame({"variant": ["corrected"] * count, **columns})


def test_methods_stand_by_the_score_of_their_free_runs():
    table = uncertainty_table(
        runs(
            method=["pem", "pem", "pem", "ls", "arx"],
            coverage_95=[0.9, 1.0, 0.8, 0.2, None],
            crps_median=[0.1, 0.3, 0.2, 0.5, None],
            coverage_free=[0.5, 0.7, None, 0.1, None],
            crps_free=[0.2, 0.4, None, 0.1, None],
        )
    )
    assert [row[0].text for row in table.rows] == ["ls", "pem"]  # arx states nothing
    pem = dict(zip(table.columns, (cell.text for cell in table.rows[1]), strict=True))
    assert pem == {
        "method": "pem", "runs": "3", "parameters inside": "90 %", "CRPS of parameters": "0.2",
        "free run inside": "60 %", "CRPS of free runs": "0.3",
    }  # fmt: skip


def test_a_method_whose_draws_diverge_stands_last():
    table = uncertainty_table(runs(method=["a", "b"], coverage_free=[None, 0.5], crps_free=[float("inf"), 0.5]))
    assert [row[0].text for row in table.rows] == ["b", "a"] and table.rows[1][-1].text == "inf"


def test_results_of_older_suites_have_no_table():
    old = runs(method=["pem"], case=["equations known"])
    assert not uncertainty_table(old).rows and uncertainty_finding(old) is None


def test_the_finding_names_every_case_that_was_scored():
    cases = pd.Categorical(["equations known"] * 2 + ["measured ships"], ["equations known", "measured ships"])
    found = uncertainty_finding(runs(method=["a", "b", "c"], case=cases, coverage_free=[0.9, 0.8, 0.25]))
    assert found is not None and "equations known 85 % (2 runs), measured ships 25 % (1 runs)" in found


@pytest.mark.parametrize("missing", [[None, None], [float("nan")] * 2])
def test_without_a_share_there_is_no_finding(missing):
    assert uncertainty_finding(runs(method=["a", "b"], case=["x", "x"], coverage_free=missing)) is None
