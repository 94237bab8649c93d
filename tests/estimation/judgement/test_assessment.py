"""What an estimate is worth: the verdicts, and the figures behind them."""

from dataclasses import replace

import numpy as np
import pytest

from helmbench.datasets.generator import Case, generate
from helmbench.estimation.estimates.assessment import APPROXIMATES, EXPLAINS, FAILS, assess
from helmbench.estimation.validation.validate import validate
from helmbench.methods.registry import make
from helmbench.models.model import resolve
from helmbench.models.published import published_values
from helmbench.reporting import media
from helmbench.reporting.identification.page import headline, page, statement

from ...simulators.response import STEP_S, second_order


@pytest.fixture(scope="module")
def records():
    texts = ("zigzag:20/20", "zigzag:10/10:port")
    return [generate(Case("response-1", text, "low", seed=k)) for k, text in enumerate(texts)]


def fitted(records, model="response-1", method="output-error"):
    return make(method).fit(records, resolve(model))


def test_the_right_model_explains(records):
    found = assess(fitted(records[:1]), records[:1], records[1:])
    assert found.verdict == EXPLAINS and not found.exceeding and not found.diverged
    assert [one.channel for one in found.held_out_residuals] == ["yaw_rate_rad_s", "heading_rad"]
    own = {one.name: one for one in found.parameters}
    truth = resolve("response-1").parameters
    for name, one in own.items():
        assert (
            one.low == pytest.approx(one.value - 1.959964 * one.stderr) and one.published["response-1"] == truth[name]
        )
    assert own["T"].bound == found.identifiability.parameters[0].relative


def test_a_model_that_lacks_a_term_approximates(records):
    found = assess(fitted(records[:1], "nomoto-1"), records[:1], records[1:])
    assert found.verdict == APPROXIMATES and {one.channel for one in found.exceeding} == {
        "yaw_rate_rad_s",
        "heading_rad",
    }
    assert found.correlated and found.judged is found.held_out


def test_a_wrong_or_diverging_model_fails(records):
    good = fitted(records[:1])
    for factor, lost in ((0.2, False), (-1.0, True)):
        wrong = replace(good, model=good.model.with_coefficients(factor * good.coefficients))
        found = assess(wrong, records[:1], records[1:])
        assert found.verdict == FAILS and bool(found.diverged) is lost


def test_what_predicts_only_shortly_is_told_with_its_time(records):
    good = fitted(records[:1])
    found = assess(replace(good, model=good.model.with_coefficients(0.2 * good.coefficients)), records[:1], records[1:])
    assert found.r2 < 0.5 and found.trusted_s > 0.0
    assert headline(found) == f"Do not predict further ahead than {found.trusted_s:.3g} s with this model."


def test_numbers_that_one_frequency_does_not_tell_apart_are_no_reason_not_to_predict():
    rudder = np.deg2rad(15.0) * np.sin(0.3 * STEP_S * np.arange(400))
    record = second_order(rudder, (12.0, 2.0, 4.0), gain=0.1, seed=5, noise=3.0)
    found = assess(fitted([record], "nomoto-2"), [record])
    assert found.r2 < 0.5 and found.verdict == EXPLAINS and found.trusted_s == max(found.train.horizons_s)
    said = media.terminal(page(found))
    assert "Do not predict" not in said and "T2, T3 and K are known well only in combination: T2 - " in said
    assert f"Predict no further ahead than {found.trusted_s:.3g} s" in said and "From the starts that fit best" in said


def test_a_model_that_is_nowhere_better_than_none_fails(records):
    found = assess(fitted(records[:1]), records[:1])
    beaten = tuple(replace(s, rmse=0.0) for s in found.train.simple)
    beaten = replace(found, train=replace(found.train, simple=beaten, trusted_s={found.name: 0.0}))
    assert found.verdict == EXPLAINS and beaten.r2 > 0.9 and beaten.verdict == FAILS
    assert "at no time ahead are its predictions better" in media.terminal(page(beaten))
    first, second = found.train.horizons_s[:2]
    simple = tuple(replace(s, rmse=0.0 if s.horizon_s == first else s.rmse) for s in found.train.simple)
    later = replace(found, train=replace(found.train, simple=simple, trusted_s={found.name: 0.0}))
    assert (
        later.verdict == EXPLAINS
        and f"only from {second:.3g} s ahead on are its predictions better" in media.terminal(page(later))
    )


def test_a_model_with_a_negative_r2_on_held_out_records_fails(records):
    found = assess(fitted(records[:1]), records[:1], records[1:])
    scores = tuple(replace(s, r2=-0.1) if s.channel is None else s for s in found.held_out.scores)
    missed = replace(found, held_out=replace(found.held_out, scores=scores))
    assert found.verdict == EXPLAINS and missed.verdict == FAILS
    assert headline(missed).startswith("Do not predict further ahead than")
    assert not any("counts as explained" in line for line in statement(missed))


def test_its_errors_are_those_of_a_validation(records):
    estimate = fitted(records[:1], "nomoto-1")
    told = assess(estimate, records[:1], records[1:]).to_json()
    score = validate({"m": estimate.model}, {"r": records[1]}).score("yaw_rate_rad_s")
    assert told["validation"]["rmse_free_yaw_rate_rad_s"] == score.rmse
    assert told["validation"]["r2_free_yaw_rate_rad_s"] == score.r2
    assert told["training"]["records"] == [records[0].name] and told["tested"] is True


@pytest.mark.nightly
def test_a_black_box_is_assessed_by_its_runs(records):
    found = assess(fitted(records[:1], "nomoto-1", "sklearn:Ridge"), records[:1], records[1:])
    assert found.parameters == () and found.identifiability is None and "black box" in found.not_told
    run = found.held_out.runs[0].predicted["yaw_rate_rad_s"]
    assert np.isfinite(run).all() and found.held_out.score("yaw_rate_rad_s").r2 > 0.8


def test_a_held_out_record_without_the_channels_is_told_not_fatal(records):
    bare = replace(records[1].with_channels(heading_rad=None, yaw_rate_rad_s=None, surge_m_s=np.ones(records[1].n)),
                   name="bare")  # fmt: skip
    found = assess(fitted(records[:1]), records[:1], [records[1], bare])
    assert [run.record for run in found.held_out.runs] == [records[1].name]
    assert "bare" in {one.record for one in found.held_out.left_out}


def test_published_values_are_of_the_same_kind_and_unit():
    found = published_values(resolve("nomoto-2"))
    assert set(found["K"]) >= {"cargo", "patrol", "response-1"} and set(found["T1"]) == {"cargo", "patrol"}
    own = published_values(resolve("mariner"))
    assert all(set(values) == {"mariner", "mariner-model"} for values in own.values())
    assert own[next(iter(own))]["mariner"] == resolve("mariner").parameters[next(iter(own))]
