"""Rates, intervals and figures from hand-made cases."""

import numpy as np
import pytest
from scipy.stats import binomtest

from helmbench.bench.kinds import DIAGNOSIS, kind_of
from helmbench.bench.kinds.diagnosis.plan import ORACLE
from helmbench.bench.store import Store, frames
from helmbench.models.errors import BadInput
from helmbench.reporting.diagnosis_suite import page, rates

WHICH = ("before", "after", "truth")


def board_of(runs):
    return rates.build(*frames(runs, kind_of(DIAGNOSIS).tables))


def rate(board, name, method="innovations", scope="all", group="all"):
    table = board.rates
    pick = (table["rate"] == name) & (table["method"] == method) & (table["scope"] == scope) & (table["group"] == group)
    (row,) = table[pick].to_dict("records")
    return row


@pytest.fixture
def runs(case_of):
    """Two methods on injected, clean, unknown and paired cases, and the oracle on one."""
    size = {"cause": "rudder_offset", "parameter": "delta0", "true": 1.0, "estimate": 1.1, "low": 0.9, "high": 1.3}
    missed = {"outcome": "missed", "named": "", "verdict": "adequate", "tie_size": None}
    wrong = {"outcome": "wrong_first", "named": "wind", "confident_wrong": True, "tie_size": None}
    clean = {"group": "null", "injected": "", "strength": "none", "detectable": None, "noncentrality": None}
    quiet = clean | {"outcome": "adequate", "named": "", "verdict": "adequate", "described": ""}
    loud = clean | {"outcome": "false_alarm", "named": "wind"}
    unknown = {
        "group": "unforeseen",
        "injected": "kind",
        "outcome": "unexplained",
        "named": "",
        "verdict": "unexplained",
    }
    pair = {"group": "pair", "injected": "rudder_offset+wind", "outcome": "both"}
    return [
        case_of(seed=1, size_of=size | {"covered": True, "rel_error": 0.1}),
        case_of(seed=2, outcome="tie", named="constant_force/rudder_offset", tie_size=2, gusts="slow"),
        case_of(seed=3, **missed),
        case_of(seed=4, **missed, detectable=False, noncentrality=2.0, strength="undetectable"),
        case_of(seed=5, **wrong, size_of=size | {"covered": False, "rel_error": 0.3}),
        case_of(seed=6, status="failed", error="burst", outcome=None, named=None, verdict=None, confident_wrong=None),
        case_of(seed=7, **quiet), case_of(seed=8, **quiet), case_of(seed=9, **loud),
        case_of(seed=10, **quiet, gusts="slow"),
        case_of(seed=11, **unknown),
        case_of(seed=12, **unknown | {"outcome": "named", "named": "current", "verdict": "named"}),
        case_of(seed=13, **pair), case_of(seed=14, **pair | {"outcome": "one"}),
        case_of(seed=1, method="naive", **wrong), case_of(seed=7, method="naive", **loud),
        case_of(seed=1, method=ORACLE, rmse_after_heading_rad=0.1),
    ]  # fmt: skip


def test_rates_count_what_they_say(runs):
    board = board_of(runs)
    told = {name: (rate(board, name)["hits"], rate(board, name)["n"]) for name in board.rates["rate"].unique()}
    assert told == {
        "named": (2, 5), "alone": (1, 5), "false_clean": (1, 3), "false_slow": (0, 1), "wrong": (1, 8),
        "described": (0, 4), "unforeseen_clean": (1, 2), "both": (1, 2), "extra": (0, 8), "worse": (0, 8),
    }  # fmt: skip
    assert (rate(board, "named", "naive")["hits"], rate(board, "false_clean", "naive")["hits"]) == (0, 1)
    assert rate(board, "named", scope="gusts", group="slow")["value"] == 1.0


def test_descriptions_are_counted(case_of):
    """Two unknown effects of the largest size, one described by its variable and halved; two clean records, one of them
    described."""
    unknown = {"group": "anticipated", "injected": "harmonic", "strength": "largest", "outcome": "unexplained"}
    clean = {"group": "null", "injected": "", "strength": "none", "outcome": "adequate", "detectable": None}

    def errors(heading, rate):
        """Before and after, of a heading of which the true ship leaves .01 rad and a yaw rate of which it leaves 1e-3
        rad/s."""
        channels = {"heading_rad": (*heading, 0.01), "yaw_rate_rad_s": (*rate, 1e-3)}
        whole = {c: channels.get(c, (1.0, 1.0, 1.0)) for c in rates.GAIN_CHANNELS}
        return {f"rmse_{w}_{c}": x for c, each in whole.items() for w, x in zip(WHICH, each, strict=True)}

    of_rate, of_heading = errors((0.02, 0.02), (0.03, 0.001)), errors((0.2, 0.15), (0.002, 0.001))
    board = board_of([
        case_of(seed=1, **unknown, **of_rate, described="heading", right_variable=True),
        case_of(seed=2, **unknown, **of_heading, described="time", right_variable=False),
        case_of(seed=3, **clean, described=""),
        case_of(seed=4, **clean, described="speed"),
    ])  # fmt: skip
    assert [(rate(board, n)["hits"], rate(board, n)["n"]) for n in ("right_variable", "halved", "described")] == [
        (1, 2), (1, 2), (1, 2)
    ]  # fmt: skip


def test_worse_than_the_base_counts_apart_where_the_true_ship_is_not(case_of):
    """Four cases above the base or not, in the first two of which the true ship without gusts is above it as well."""
    known = dict.fromkeys((f"rmse_truth_{c}" for c in rates.GAIN_CHANNELS), 0.01)
    before = {f"rmse_before_{c}": 1.0 for c in rates.GAIN_CHANNELS}
    after = {f"rmse_after_{c}": 1.0 for c in rates.GAIN_CHANNELS}
    gusty = known | {"rmse_truth_sway_m_s": 1.1}
    pairs = ((1.2, gusty), (0.9, gusty), (1.2, known), (0.9, known))
    cases = [
        case_of(seed=i, **before, **truth, **after | {"rmse_after_heading_rad": heading})
        for i, (heading, truth) in enumerate(pairs)
    ]
    board = board_of(cases)
    assert (rate(board, "worse")["hits"], rate(board, "worse")["n"]) == (2, 4)
    assert (rate(board, "worse_than_possible")["hits"], rate(board, "worse_than_possible")["n"]) == (1, 2)


def test_what_is_asked_for_is_compared_with_the_rate(runs):
    board = board_of(runs)
    assert (
        not rate(board, "named")["met"] and rate(board, "false_slow")["met"] and not rate(board, "false_clean")["met"]
    )
    assert rate(board, "alone")["met"] is None


def test_intervals_are_those_of_clopper_and_pearson(rng):
    n = int(rng.integers(1, 200))
    hits = int(rng.integers(0, n + 1))
    wanted = binomtest(hits, n).proportion_ci(0.95, method="exact")
    assert rates.binomial_interval(hits, n) == pytest.approx((wanted.low, wanted.high))
    assert np.isnan(rates.binomial_interval(0, 0)).all()


def test_figures(runs):
    board = board_of(runs)
    own = {row["rate"]: row for row in board.figures.to_dict("records") if row["method"] == "innovations"}
    assert own["tie_size"]["value"] == 1.5 and not own["tie_size"]["met"]
    assert own["coverage"]["value"] == 0.5 and own["coverage"]["n"] == 2
    assert own["gain_median"]["value"] == pytest.approx(1.1) and own["gain_median"]["n"] == 1
    assert own["wall_s"]["value"] == 3.0


def test_the_oracle_is_not_a_competitor(runs):
    board = board_of(runs)
    assert ORACLE not in set(board.rates["method"]) | set(board.confusion["method"])


def test_confusion_counts_a_tie_with_the_truth_as_the_truth(runs):
    table = board_of(runs).confusion
    own = {(r["injected"], r["named"]): r["cases"] for r in table[table["method"] == "innovations"].to_dict("records")}
    assert own == {
        ("rudder_offset", "rudder_offset"): 2, ("rudder_offset", "(adequate)"): 1, ("rudder_offset", "wind"): 1,
        ("(null)", "(adequate)"): 3, ("(null)", "wind"): 1,
        ("(unforeseen)", "(unexplained)"): 1, ("(unforeseen)", "current"): 1,
    }  # fmt: skip


def test_power_is_counted_between_edges(runs):
    table = board_of(runs).power
    calm = table[(table["method"] == "innovations") & (table["weather"] == "calm")]
    assert calm[["from", "n", "hits"]].values.tolist() == [[1.0, 1, 0], [60.0, 4, 1]]


@pytest.fixture
def directory(tmp_path, runs):
    manifest = {
        "kind": DIAGNOSIS, "suite": "made-up", "version": "0", "planned": len(runs) + 1,
        "selection": {"suite": "made-up", "seed": 12}, "packages": {"numpy": "2"},
    }  # fmt: skip
    with Store.create(tmp_path / "out", manifest) as store:
        for run in runs:
            store.append(run)
    return tmp_path / "out"


def test_the_report_is_written_and_says_what_is_missing(directory):
    written = page.write_report(directory)
    assert sorted(path.name for path in written.paths) == ["diagnosis.csv", "diagnosis.html", "diagnosis.md"]
    assert not written.complete and "INCOMPLETE: 17 of 18" in written.markdown and "seed 12" in written.markdown
    assert "40.0 % [5.3, 85.3], n = 5 ✗" in written.markdown and "burst" in written.markdown
    text = (directory / "diagnosis.html").read_text()
    assert text.count("<svg") == 2 and "naive" in text and "http" not in text.replace("http://www.w3.org", "")


def test_a_report_of_nothing_is_refused(tmp_path):
    manifest = {"kind": DIAGNOSIS, "suite": "made-up", "version": "0", "planned": 3, "selection": {}}
    Store.create(tmp_path / "out", manifest).close()
    with pytest.raises(BadInput, match="no case is finished"):
        page.write_report(tmp_path / "out")


def test_imperfect_bases_are_compared_with_what_the_oracle_reaches(case_of):
    """Four effects beside imperfect bases, of which the oracle names three and the diagnosis two, and two clean
    records."""
    missed = {"outcome": "missed", "named": "base_coefficients", "tie_size": None}
    clean = {"group": "null", "injected": "", "strength": "none", "detectable": None, "noncentrality": None}
    clean |= {"outcome": "adequate", "named": "", "verdict": "named"}
    off = {"base": "off-10"}
    told = [
        case_of(seed=1, rmse_after_heading_rad=0.1, **off), case_of(seed=2, rmse_after_heading_rad=0.2, **off),
        case_of(seed=3, rmse_after_heading_rad=0.1, **off, **missed), case_of(seed=4, **off, **missed),
        case_of(seed=5, **off, **clean, extra_names=1), case_of(seed=6, **off, **clean, extra_names=0),
        case_of(seed=7),
    ]  # fmt: skip
    oracle = [case_of(seed=i, method=ORACLE, rmse_after_heading_rad=0.1, **off) for i in (1, 2, 3)]
    board = board_of([*told, *oracle, case_of(seed=4, method=ORACLE, **off, **missed)])
    counted = {name: (rate(board, name)["hits"], rate(board, name)["n"]) for name in
               ("named", "named_beside", "false_beside", "close_beside")}  # fmt: skip
    assert counted == {"named": (3, 5), "named_beside": (2, 3), "false_beside": (1, 2), "close_beside": (3, 4)}
    assert "false_clean" not in set(board.rates["rate"])


def test_false_discoveries_are_a_share_of_the_names(case_of):
    """Four cases: of two names one is false, the one name is, none is, and nothing is named."""
    told = [
        case_of(seed=i, group="planted-null", names=n, false_names=k)
        for i, (n, k) in enumerate([(2, 1), (1, 1), (3, 0), (0, 0)])
    ]
    board = board_of(told)
    (row,) = (row for row in board.figures.to_dict("records") if row["rate"] == "false_discovery")
    assert (row["n"], row["value"], row["met"]) == (4, pytest.approx(1.5 / 4), False)
    assert 0.0 < row["low"] < row["value"] < row["high"] < 1.0
    assert (rate(board, "planted")["hits"], rate(board, "planted")["n"]) == (3, 4)
    clean = (
        board_of([case_of(seed=i, names=0, false_names=0) for i in range(50)])
        .figures.set_index("rate")
        .loc["false_discovery"]
    )
    assert (clean["value"], clean["low"]) == (0.0, 0.0) and clean["high"] == pytest.approx(1.0 - 0.025 ** (1 / 50))


def test_wrong_numbers_and_regimes_are_counted(case_of):
    """Three bugs named alone, among others and not at all, and two faults in a regime, of which one is located."""
    bug = {"group": "one-bug", "injected": "", "strength": "none", "base": "propeller", "detectable": None}
    regime = {"group": "regime", "injected": "rudder_stall", "base": "unstated", "regime_true": "rudder above 0.2"}
    cases = [
        case_of(seed=1, **bug, healthy_bias=0.05, regime_true="", regime_named=""),
        case_of(seed=2, **bug, outcome="among", healthy_bias=0.5, regime_true="", regime_named="rudder above 0.1"),
        case_of(seed=3, **bug, outcome="missed", healthy_bias=0.0, regime_true="", regime_named=""),
        case_of(seed=4, **regime, regime_f1=0.9, healthy_bias=0.02), case_of(seed=5, **regime, regime_f1=0.0),
    ]  # fmt: skip
    board = board_of(cases)
    counted = {name: (rate(board, name)["hits"], rate(board, name)["n"]) for name in
               ("bug_alone", "bug_among", "bug_verdict", "regime_f1", "regime_false", "healthy")}  # fmt: skip
    assert counted == {
        "bug_alone": (1, 3), "bug_among": (2, 3), "bug_verdict": (1, 1), "regime_f1": (1, 2), "regime_false": (1, 3),
        "healthy": (3, 4),
    }  # fmt: skip
    assert rate(board, "bug_alone", scope="base", group="propeller")["n"] == 3
    assert "named" not in set(board.rates["rate"])
