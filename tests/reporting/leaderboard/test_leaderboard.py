"""Leaderboard maths on tables small enough to check by hand."""

import math

import numpy as np
import pandas as pd
import pytest
from hypothesis import given
from hypothesis import strategies as st

from helmbench.bench.kinds import IDENTIFICATION, kind_of
from helmbench.bench.store import frames
from helmbench.reporting.leaderboard import standings as leaderboard
from helmbench.reporting.leaderboard.board import build


def board(runs):
    return build(*frames(runs, kind_of(IDENTIFICATION).tables))


def by_method(table):
    return {row["method"]: row for row in table.to_dict("records")}


def test_ranks_are_averaged_over_cells(run_of):
    runs = [
        run_of(error=0.1, method="a", vessel="v1"),
        run_of(error=0.2, method="b", vessel="v1"),
        run_of(error=0.3, method="c", vessel="v1"),
        run_of(error=0.5, method="a", vessel="v2"),
        run_of(error=0.1, method="b", vessel="v2"),
        run_of(error=0.3, method="c", vessel="v2"),
    ]
    found = by_method(board(runs).overall)
    assert [found[name]["mean_rank"] for name in "abc"] == [2.0, 1.5, 2.5]
    assert list(found) == ["b", "a", "c"]
    assert found["a"]["rel_error"] == pytest.approx(0.3) and found["a"]["cells"] == 2


def test_equal_errors_share_their_rank_and_rounding_decides_none(run_of):
    runs = [run_of(error=e, method=m) for m, e in (("a", 1e-13), ("b", 1e-9), ("c", 0.2), ("d", 0.2))]
    found = by_method(board(runs).overall)
    assert [found[name]["mean_rank"] for name in "abcd"] == [1.5, 1.5, 3.5, 3.5]


def test_both_criteria_count_alike(run_of):
    runs = [run_of(error=0.1, r2=0.2, method="a"), run_of(error=0.2, r2=0.9, method="b")]
    found = by_method(board(runs).overall)
    assert (found["a"]["rank_parameters"], found["a"]["rank_prediction"], found["a"]["mean_rank"]) == (1.0, 2.0, 1.5)
    assert found["b"]["nrmse"] == pytest.approx(math.sqrt(0.1))


def test_seeds_are_repetitions_inside_a_cell(run_of):
    runs = [run_of(error=e, method="a", seed=s) for s, e in enumerate((0.1, 0.2, 9.0))]
    runs += [run_of(error=0.3, method="b", seed=s) for s in range(3)]
    found = by_method(board(runs).overall)
    assert (found["a"]["rel_error"], found["a"]["mean_rank"], found["a"]["cells"]) == (pytest.approx(0.2), 1.0, 1)


def test_a_failed_run_ranks_last_and_is_an_infinite_error(run_of):
    runs = [
        run_of(error=0.9, r2=-3.0, method="bad"),
        run_of(error=0.1, r2=0.9, method="good"),
        run_of(method="broken", status="failed", reason="singular"),
    ]
    found = by_method(board(runs).overall)
    assert [found[name]["mean_rank"] for name in ("good", "bad", "broken")] == [1.0, 2.0, 3.0]
    assert found["broken"]["rel_error"] == math.inf and found["broken"]["nrmse"] == math.inf
    assert (found["broken"]["failed"], found["broken"]["runs"], found["broken"]["ok"]) == (1, 1, 0)


def test_failures_of_most_seeds_make_the_median_infinite(run_of):
    runs = [run_of(error=0.1, method="a", seed=0)]
    runs += [run_of(method="a", seed=s, status="failed", reason="x") for s in (1, 2)]
    runs += [run_of(error=0.5, method="b", seed=s) for s in range(3)]
    found = by_method(board(runs).overall)
    assert found["a"]["rel_error"] == math.inf and found["a"]["mean_rank"] == 2.0 and found["a"]["failed"] == 2


def test_not_applicable_is_counted_and_not_ranked(run_of):
    runs = [
        run_of(error=0.1, method="a"),
        run_of(error=0.2, method="b"),
        run_of(method="c", status="not_applicable", reason="no sway"),
    ]
    found = by_method(board(runs).overall)
    assert math.isnan(found["c"]["mean_rank"]) and found["c"]["not_applicable"] == 1
    assert list(found) == ["a", "b", "c"]


def test_medians_of_every_prediction_metric_count_diverged_and_failed_runs(run_of):
    ships = ("v1", "v2", "v3")
    runs = [run_of(error=0.1, r2=0.9, method="good", vessel=ship) for ship in ships]
    runs += [run_of(error=0.1, r2=0.99, method="bad", vessel="v1")]
    runs += [run_of(error=0.1, r2=0.8, method="bad", vessel="v2", diverged=True)]
    runs += [run_of(method="bad", vessel="v3", status="failed", reason="singular")]
    found = by_method(board(runs).overall)
    assert found["bad"]["nrmse"] == found["bad"]["rmse_yaw_rate_rad_s"] == found["bad"]["rmse_heading_rad"] == math.inf
    assert found["bad"]["r2_yaw_rate"] == found["bad"]["r2_heading"] == -math.inf
    assert found["good"]["rmse_yaw_rate_rad_s"] == 0.01 and found["good"]["r2_yaw_rate"] == 0.9


def test_a_channel_that_nothing_scores_is_no_error_of_a_failed_run(run_of):
    runs = [run_of(error=0.1, method="a"), run_of(method="b", status="failed", reason="singular")]
    assert math.isnan(by_method(board(runs).overall)["b"]["rmse_yaw_rate_rad_s"])


def test_a_diverged_run_has_an_infinite_prediction_error_but_keeps_its_parameters(run_of):
    runs = [run_of(error=0.1, r2=0.9, method="a", diverged=True), run_of(error=0.2, r2=-5.0, method="b")]
    found = by_method(board(runs).overall)
    assert found["a"]["nrmse"] == math.inf and found["a"]["rank_prediction"] == 2.0
    assert found["a"]["rank_parameters"] == 1.0 and found["a"]["diverged"] == 1


def test_derived_truths_take_no_part_in_parameter_ranks(run_of, parameter_of):
    derived = [parameter_of("K", 1.0, 1.4, 0.1, kind="derived")]
    runs = [run_of(error=0.4, r2=0.9, method=m, model="nomoto-1", parameters=derived) for m in ("a", "b")]
    found = by_method(board(runs).overall)
    assert math.isnan(found["a"]["rank_parameters"]) and math.isnan(found["a"]["rel_error"])
    assert found["a"]["rank_prediction"] == 1.5


def test_a_cell_with_one_method_ranks_nothing_but_shows_its_figures(run_of):
    found = by_method(board([run_of(error=0.1, r2=0.9)]).overall)
    assert math.isnan(found["ls"]["mean_rank"]) and found["ls"]["rel_error"] == pytest.approx(0.1)


def test_medians_of_ranked_methods_leave_out_cells_without_competition(run_of):
    runs = [
        run_of(error=1e-12, method="a", train="zigzag:20/20@euler"),
        run_of(error=0.4, method="a"),
        run_of(error=0.2, method="b"),
    ]
    found = by_method(board(runs).overall)
    assert found["a"]["rel_error"] == pytest.approx(0.4) and found["a"]["runs"] == 2 and found["a"]["cells"] == 1


def test_the_printed_variant_is_a_competitor_of_its_own(run_of):
    runs = [run_of(error=0.1, method="rls"), run_of(error=0.3, method="rls", variant="as_printed")]
    assert list(by_method(board(runs).overall)) == ["rls", "rls (as_printed)"]


def test_levels_are_sorted_as_one_reads_them():
    levels = ["low,outliers=10%", "16", "gross", "low,outliers=5%", "4", "low", "none", "low,bursts=5%", "0.5", "1"]
    expected = ["none", "low", "low,bursts=5%", "low,outliers=5%", "low,outliers=10%", "gross", "0.5", "1", "4", "16"]
    assert sorted(levels, key=leaderboard.in_order) == expected


def test_efficiency_is_the_bound_over_the_mean_squared_error(run_of, parameter_of):
    errors, sd = (0.1, -0.2, 0.3), 0.15
    runs = [run_of(error=0.1, seed=s, parameters=[parameter_of("K", 2.0, 2.0 + e, sd)]) for s, e in enumerate(errors)]
    expected = sd**2 / np.mean(np.square(errors))
    assert by_method(board(runs).overall)["ls"]["efficiency"] == pytest.approx(expected)


@pytest.mark.parametrize(
    "change",
    [{"kind": "derived"}, {"identifiable": False}, {"crb_sd": None}],
    ids=["derived truth", "not identifiable", "no bound"],
)
def test_efficiency_is_stated_only_where_it_means_something(run_of, parameter_of, change):
    facts = {"kind": "given", "identifiable": True, "crb_sd": 0.1} | change
    rows = [parameter_of("K", 1.0, 1.1, facts["crb_sd"], facts["kind"], facts["identifiable"])]
    runs = [run_of(error=0.1, seed=s, parameters=rows) for s in range(4)]
    assert math.isnan(by_method(board(runs).overall)["ls"]["efficiency"])


def test_efficiency_needs_several_seeds_and_calm_water(run_of, parameter_of):
    rows = [parameter_of("K", 1.0, 1.1, 0.1)]
    for runs in (
        [run_of(error=0.1, seed=s, parameters=rows) for s in range(2)],
        [run_of(error=0.1, seed=s, parameters=rows, disturbance="wind:8@40deg") for s in range(4)],
    ):
        assert math.isnan(by_method(board(runs).overall)["ls"]["efficiency"])


def test_failures_are_listed_once_a_reason_with_their_seeds(run_of):
    runs = [run_of(method="a", seed=s, status="failed", reason="singular") for s in (2, 0, 1)]
    runs += [run_of(method="a", seed=9, status="not_applicable", reason="no sway"), run_of(error=0.1, method="b")]
    told = board(runs).failures.to_dict("records")
    assert [(row["status"], row["runs"], row["seeds"], row["error"]) for row in told] == [
        ("failed", 3, "0, 1, 2", "singular"),
        ("not_applicable", 1, "9", "no sway"),
    ]


def test_a_fit_that_did_not_converge_is_told(run_of):
    runs = [run_of(error=0.1, reason="not converged: 100 iterations")]
    assert board(runs).failures["error"].tolist() == ["not converged: 100 iterations"]


@given(st.lists(st.floats(0.0, 1e6), min_size=1, max_size=30))
def test_bootstrap_intervals_are_repeatable_and_inside_the_values(values):
    low, high = leaderboard.bootstrap_interval(values)
    assert min(values) <= low <= high <= max(values)
    assert (low, high) == leaderboard.bootstrap_interval(values)


def test_bootstrap_interval_covers_the_median_at_its_level(rng):
    hits = 0
    for _ in range(200):
        low, high = leaderboard.bootstrap_interval(rng.normal(size=25), draws=400)
        hits += low <= 0.0 <= high
    assert hits >= 174  # 95 % of 200 less four standard deviations of the count


def test_bootstrap_takes_infinite_errors_as_they_are():
    assert leaderboard.bootstrap_interval([math.inf, math.inf, math.inf]) == (math.inf, math.inf)
    low, high = leaderboard.bootstrap_interval([0.1, 0.2, math.inf])
    assert low == 0.1 and high == math.inf


def test_normalised_error_is_the_mean_over_scored_channels(run_of):
    run = run_of(error=0.1)
    run["row"] |= {"r2_free_heading_rad": 0.75, "r2_free_yaw_rate_rad_s": 1.0, "r2_free_north_m": -8.0}
    results, _ = frames([run], kind_of(IDENTIFICATION).tables)
    assert leaderboard.normalised_error(results).tolist() == [0.25]


def test_methods_of_other_variants_have_labels_of_their_own():
    frame = pd.DataFrame({"method": ["rls", "ls", "rls"], "variant": ["corrected", "corrected", "as_printed"]})
    assert leaderboard.labels(frame).tolist() == ["rls", "ls", "rls (as_printed)"]
