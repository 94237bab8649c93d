"""The comparison on every vessel: its statistics against scipy and known cases, its pairs, its across."""

import math
from functools import partial
from pathlib import Path

import numpy as np
import pytest

from helmbench.methods.ls_svr import TUNERS, colony
from helmbench.models.errors import CannotFit, FitFailed
from helmbench.models.model import resolve
from helmbench.reproduction import stability
from helmbench.reproduction.claims.claim import Headline, OwnComparison, SettingRange, SettingSearch
from helmbench.reproduction.claims.files import ACROSS, load, papers
from helmbench.reproduction.pages import across
from helmbench.reproduction.papers.paper_across import studies
from helmbench.reproduction.papers.paper_across.studies import BETTER, BOTH_FAIL, EQUAL, WORSE, holm, outcome, paired
from helmbench.reproduction.papers.study import point
from helmbench.reproduction.results import Results
from helmbench.reproduction.verdicts import NOTHING, spread


def test_all_vessels_take_part():
    from helmbench import list_vessels

    assert set(studies.VESSELS) == set(list_vessels())
    assert set(load(ACROSS).studies) == set(studies.STUDIES) == {*studies.VESSELS, "proposed"}
    assert studies.STUDIES["proposed"].seeds == len(studies.VESSELS) * len(studies.NOISE)


def test_paired_differences(rng):
    other = rng.uniform(0.1, 2.0, size=20)
    always = paired(0.5 * other, other, 10.0)
    assert (always["won"], always["effect"], always["ratio"]) == (1.0, 1.0, pytest.approx(0.5))
    assert always["p"] < 1e-4
    assert paired(other, other, 10.0) | {"error": 0, "baseline": 0} == {
        "error": 0, "baseline": 0, "ratio": 1.0, "won": 0.5, "effect": 0.0, "p": 1.0, "failed": 0.0,
        "baseline_failed": 0.0,
    }  # fmt: skip
    worse = paired(2.0 * other, other, 10.0)
    assert (worse["won"], worse["effect"]) == (0.0, -1.0) and worse["p"] == pytest.approx(always["p"])


def test_without_a_difference_few_tests_reject(rng):
    """Two equal methods: at most about 5 % of 400 tests."""
    p = [paired(np.exp(rng.normal(size=20)), np.exp(rng.normal(size=20)), 1e9)["p"] for _ in range(400)]
    assert np.mean(np.array(p) < 0.05) < 0.05 + 4.0 * math.sqrt(0.05 * 0.95 / 400)


def test_holm():
    """The example of Holm's procedure: .01, .04, .03, .005 of four tests."""
    found = holm({"a": 0.01, "b": 0.04, "c": 0.03, "d": 0.005})
    assert found == pytest.approx({"a": 0.03, "b": 0.06, "c": 0.06, "d": 0.02})
    assert holm({"a": 0.9, "b": 0.8}) == {"a": 1.0, "b": 1.0}


@pytest.mark.parametrize(
    ("adjusted", "ratio", "error", "baseline", "expected"),
    [
        (0.01, 0.5, 0.1, 0.2, BETTER),
        (0.01, 2.0, 0.2, 0.1, WORSE),
        (0.06, 0.5, 0.1, 0.2, EQUAL),
        (0.001, 0.995, 0.199, 0.2, EQUAL),
        (0.001, 0.5, 5.0, 10.0, BOTH_FAIL),
        (0.001, 50.0, 10.0, 0.2, WORSE),
    ],
)
def test_outcomes(adjusted, ratio, error, baseline, expected):
    assert outcome(adjusted, ratio, error, baseline) == expected


def test_one_vessel_with_two_records(monkeypatch, rng):
    monkeypatch.setattr(studies, "SEEDS", 2)
    monkeypatch.setattr(studies, "NOISE", ("low",))
    values = studies.pairs_on("response-1", rng, index=0).values
    assert {key.split(".")[0] for key in values} == set(studies.PAIRS) - {"a1-ls", "a1-a2"}
    assert all(np.isfinite(value) for value in values.values())
    with pytest.raises(CannotFit):
        studies.error("euler-ls", "response-1", False, False, "low", 1)


def test_the_observer_s_corner_is_that_of_svf_ls():
    """The pipeline with the corner that svf-ls found gives what it gives with a search of its own."""
    studies.CORNERS.clear()
    studies.error.cache_clear()
    alone = studies.error(studies.ESO, "cargo", True, True, "medium", 3)
    studies.error.cache_clear()
    studies.error(studies.SVF, "cargo", True, True, "medium", 3)
    assert studies.CORNERS and studies.error(studies.ESO, "cargo", True, True, "medium", 3) == alone


def test_the_proposal_is_run_at_its_place_with_its_cost(monkeypatch, rng):
    """One cycle of the colony instead of 30; the errors are those of the same methods in the other comparisons."""
    monkeypatch.setitem(TUNERS, "abc", partial(colony, cycles=1))
    monkeypatch.setattr(studies, "PLACES", (("remus-kt", "low"), ("response-1", "medium")))
    seed = int(np.random.default_rng(7).integers(2**31))
    studies.error.cache_clear()
    found = studies.proposed_at(np.random.default_rng(7), index=1).values
    own, other = (
        studies.error(text, "response-1", True, True, "medium", seed)
        for text in (studies.PROPOSED.method, studies.PROPOSED.baseline)
    )
    studies.error.cache_clear()
    key = "response-1.medium."
    assert (found[f"{key}error"], found[f"{key}baseline"]) == (own, other)
    assert found[f"{key}evaluations"] == found[f"{key}baseline_evaluations"] == 90
    assert found[f"{key}cpu_s"] > 0.0 and len(found) == 6


def test_a_proposal_that_fails_counts_as_lost(monkeypatch):
    def failing(*_):
        raise FitFailed("made up")

    monkeypatch.setattr(studies.make(studies.PROPOSED.method).__class__, "fit", failing)
    found = studies.proposed_at(np.random.default_rng(1), index=0).values
    assert found["remus-kt.low.error"] == studies.LOST and math.isnan(found["remus-kt.low.evaluations"])


def proposal(ratios):
    """Results of the study with these ratios of errors, in the order of its places."""
    values = {}
    for (vessel, noise), ratio in zip(studies.PLACES, ratios, strict=False):
        own = {"error": 0.2 * ratio, "baseline": 0.2, "evaluations": 1830.0, "cpu_s": 9.0}
        own |= {"baseline_evaluations": 1830.0, "baseline_cpu_s": 3.0}
        values |= {f"{vessel}.{noise}.{name}": spread([math.nan, value]) for name, value in own.items()}
    return Results(ACROSS, {"proposed": values})


def test_the_page_of_the_proposal_has_one_test_its_cost_and_every_place():
    text = across.page(load(ACROSS), proposal([0.5] * 20 + [1.0] * 10 + [4.0] * 6))
    section = text[text.index(f"## {studies.PROPOSED.method} against {studies.PROPOSED.baseline}") :]
    assert "smaller error in 20 of 36, the larger one in 6; the median ratio of errors is 0.5" in section
    assert "a fit takes 1830 evaluations and 9 s of CPU time, that of LS-SVR 1830 evaluations and 3 s" in section
    assert "in 0 both are worse than a constant prediction" in section
    assert section.count("0.5 (0.1, 0.2)") == 20 and section.count("4 (0.8, 0.2)") == 6
    assert all(f"| {vessel} " in section for vessel in studies.VESSELS)
    assert studies.PROPOSED.method not in across.page(load(ACROSS), Results(ACROSS, {}))


def test_ships_get_a_response_model_with_their_own_rudder():
    found = studies.structure("s175", True)
    assert found.family == "nomoto-2" and found.rudder == resolve("s175").rudder and not found.known
    assert studies.structure("s175", False).family == resolve("s175").family


@pytest.mark.parametrize(
    ("ratio", "expected"), [([0.5], "yes"), ([0.9], "no"), ([2.0], "no"), ([0.1, 0.2, 3.0], "yes")]
)
def test_answers_on_the_own_example(ratio, expected):
    assert across.own_answer(spread(ratio)) == expected
    assert across.own_answer(NOTHING) == "not settled"


def test_answers_join():
    assert (
        across.joined([("", "", "yes")] * 2) == "yes" and across.joined([("", "", "yes"), ("", "", "no")]) == "partly"
    )


def test_where_to_use_it_instead():
    """Two pairs of a headline: only where both are better."""
    quantities = {"error": 1.0, "baseline": 2.0, "won": 1.0, "effect": 1.0, "failed": 0.0, "baseline_failed": 0.0}

    def comparison(pair, ratio):
        return {f"{pair}.low.{k}": spread([v]) for k, v in (quantities | {"ratio": ratio, "p": 1e-6}).items()}

    values = {"a": comparison("mi-rls", 0.5) | comparison("nmi-rls", 0.5)}
    values["b"] = comparison("mi-rls", 0.5) | comparison("nmi-rls", 2.0)
    own_results = Results("across", values)
    own = (OwnComparison(quantity="q", study="s", key="k"),)
    headline = Headline(claim="c", method="m", baseline="b", own=own, pairs=("mi-rls", "nmi-rls"))
    assert across.instead(headline, own_results) == "low noise: a"
    assert across.instead(headline.model_copy(update=dict(pairs=("nmi-rls",))), own_results) == "low noise: a"
    assert across.on_vessels(headline.model_copy(update=dict(pairs=("mi-rls",))), own_results) == "yes"


def test_changes_between_two_reproductions():
    first = {"000 a": "reproduced", "000 b": "contradicted"}
    assert stability.changes(first, dict(first)) == []
    (change,) = stability.changes(first, first | {"000 b": "not computable"})
    assert (change[0], change[2]) == ("000 b", "not computable")


@pytest.mark.nightly
def test_the_published_pages_do_not_change_by_themselves(tmp_path, capsys):
    published = Path(__file__).parents[3] / "reports" / "reproduction"
    (tmp_path / "pages").symlink_to(published)
    assert stability.main([str(tmp_path), str(tmp_path)]) == 0
    told = capsys.readouterr().out
    assert told.startswith("0 of ") and "0 headlines changed" in told
    assert set(stability.headlines(tmp_path)) == {f"{paper} headline" for paper in papers()}


def test_points_of_a_search_fill_its_range_and_do_not_change():
    search = SettingSearch(
        study="s", ranges={"x": SettingRange(low=1.0, high=100.0, log=True)}, choices={"form": ("a", "b")}
    )
    found = [point(search, i) for i in range(32)]
    assert found == [point(search, i) for i in range(32)]
    x = np.array([entry["x"] for entry in found])
    assert x.min() < 1.3 and x.max() > 80.0 and abs(np.median(x) / 10.0 - 1.0) < 0.3
    assert {entry["form"] for entry in found} == {"a", "b"}
