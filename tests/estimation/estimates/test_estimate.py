"""What an estimate offers: predictions as records, scores, residual statistics, table and figure."""

from dataclasses import replace

import numpy as np
import pytest

from helmbench.datasets.generator import Case, generate
from helmbench.estimation.run.prediction import prediction_scores
from helmbench.methods.registry import make
from helmbench.models.errors import BadInput, CannotFit
from helmbench.models.model import resolve


@pytest.fixture(scope="module")
def records():
    return [generate(Case("response-1", text, "low", seed=1)) for text in ("zigzag:20/20", "zigzag:10/10:port")]


@pytest.fixture(scope="module")
def estimate(records):
    return make("output-error").fit(records[0], resolve("nomoto-1-cubic"))


@pytest.fixture(scope="module")
def black_box(records):
    return make("sklearn:Ridge").fit(records[0], resolve("nomoto-1"))


def error(record, other, channel):
    return np.sqrt(np.nanmean((record.column(channel) - other.column(channel)) ** 2))


def test_predictions_are_records_whose_errors_are_the_scores(estimate, records):
    scores = estimate.score(records[1])
    free, one = estimate.simulate(records[1]), estimate.predict(records[1])
    assert np.array_equal(free.time_s, records[1].time_s) and set(free.channels) == set(records[1].channels)
    assert error(free, records[1], "yaw_rate_rad_s") == pytest.approx(scores["rmse_free_yaw_rate_rad_s"])
    assert error(one, records[1], "yaw_rate_rad_s") == pytest.approx(scores["rmse_one_yaw_rate_rad_s"])
    assert np.isnan(one.column("yaw_rate_rad_s")[0]) and np.isfinite(one.column("yaw_rate_rad_s")[1:]).all()
    assert scores == prediction_scores(estimate.model, [records[1]])
    assert estimate.score(records) == prediction_scores(estimate.model, records)


def test_a_gap_has_no_prediction_of_the_next_sample(estimate, records):
    rate = records[1].column("yaw_rate_rad_s").copy()
    rate[100] = np.nan
    one = estimate.predict(records[1].with_channels(yaw_rate_rad_s=rate)).column("yaw_rate_rad_s")
    assert np.isnan(one[101]) and np.isfinite(one[[99, 100, 102]]).all()


def test_the_rudder_sign_of_a_record_is_taken_into_account(estimate, records):
    model = estimate.model
    side = "port" if model.positive_rudder == "starboard" else "starboard"
    assert estimate.score(records[1].turned(side)) == estimate.score(records[1])


def test_predictions_are_shown_as_the_models_instruments_show_them(estimate, records):
    biased = replace(estimate, model=replace(estimate.model, instruments={"yaw_rate_bias": 0.01}))
    shifted = records[1].with_channels(yaw_rate_rad_s=records[1].column("yaw_rate_rad_s") + 0.01)
    told, expected = biased.simulate(shifted), estimate.simulate(records[1])
    np.testing.assert_allclose(told.column("yaw_rate_rad_s"), expected.column("yaw_rate_rad_s") + 0.01, atol=1e-12)
    assert biased.score(shifted)["rmse_free_yaw_rate_rad_s"] == pytest.approx(
        estimate.score(records[1])["rmse_free_yaw_rate_rad_s"]
    )


def test_a_black_box_predicts_and_scores(black_box, records):
    assert black_box.score(records[1])["r2_one_yaw_rate_rad_s"] > 0.9
    assert black_box.predict(records[1]).has("yaw_rate_rad_s") and black_box.to_dataframe().empty
    assert "black box" in repr(black_box) and "black box" in black_box._repr_html_()
    with pytest.raises(BadInput, match="no parameters"):
        black_box.identifiability(records)


def test_what_cannot_be_predicted_is_said(estimate, records):
    with pytest.raises(CannotFit, match="none of the columns"):
        estimate.predict(records[0].with_channels(yaw_rate_rad_s=None, heading_rad=None))


def test_parameters_as_a_table(estimate):
    table = estimate.to_dataframe()
    assert dict(table["estimate"]) == estimate.parameters and dict(table["stderr"]) == estimate.stderr
    assert dict(table["unit"]) == dict(zip(estimate.model.parameter_names, estimate.model.parameter_units, strict=True))
    shown = estimate._repr_html_()
    assert shown.count("<tr>") == 1 + len(table) and f"{estimate.parameters['T']:.5g}" in shown
    assert repr(estimate).startswith("<Estimate of nomoto-1-cubic by output-error: T=")
    assert "not identified" in replace(estimate, stderr={"T": np.inf})._repr_html_()


def test_the_figure_has_a_panel_a_channel(estimate, records):
    figure = estimate.plot(records[1])
    assert [panel.get_ylabel() for panel in figure.axes] == ["heading\n[deg]", "yaw rate\n[deg/s]"]
    labels = [line.get_label() for line in figure.axes[1].lines]
    assert labels == ["measured", "one step", "free run"]
    measured = np.rad2deg(records[1].column("yaw_rate_rad_s"))
    np.testing.assert_allclose(figure.axes[1].lines[0].get_ydata(), measured)


def test_identifiability_at_the_estimate(estimate, records):
    assert estimate.identifiability(records[0]).counts == (3, 0, 0)
