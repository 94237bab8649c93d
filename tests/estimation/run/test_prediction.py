"""Scores on records whose right answer is known."""

from dataclasses import replace

import numpy as np
import pytest

from helmbench.datasets.generator import Case, generate
from helmbench.estimation.run.prediction import one_step, prediction_scores
from helmbench.estimation.run.squares import squares
from helmbench.models.errors import CannotFit
from helmbench.models.model import resolve

VESSELS = {"response-1": "zigzag:20/20", "response-2": "zigzag:20/20", "mariner": "turn:20", "remus": "sine:5deg/2s"}


def with_gaps(record, *channels, places):
    changed = {}
    for name in channels:
        changed[name] = record.column(name).copy()
        changed[name][places] = np.nan
    return record.with_channels(**changed)


def test_error_and_r2_by_hand():
    observed = np.array([1.0, 2.0, np.nan, 4.0, 5.0])
    rmse, r2 = squares(observed, np.array([1.0, 3.0, 9.0, 4.0, 5.0])).scores()
    assert rmse == pytest.approx(0.5) and r2 == pytest.approx(1.0 - 1.0 / 10.0)


def test_error_without_observations_or_variation_or_finite_predictions():
    nothing = np.full(3, np.nan)
    assert np.isnan(squares(nothing, np.ones(3)).scores()).all()
    rmse, r2 = squares(np.ones(3), np.full(3, 1.5)).scores()
    assert rmse == 0.5 and np.isnan(r2)
    assert np.isnan(squares(np.arange(3.0), np.array([0.0, np.inf, 2.0])).scores()).all()


@pytest.mark.parametrize("vessel", VESSELS)
def test_the_true_model_predicts_its_own_record(vessel):
    found = prediction_scores(resolve(vessel), [generate(Case(vessel, VESSELS[vessel], duration_s=2.8))])
    free = {name: value for name, value in found.items() if name.startswith("rmse_free")}
    assert not found["diverged"] and len(free) == (6 if vessel in ("mariner", "remus") else 2)
    smoothed = 1e-6 if vessel in ("response-2", "remus") else 1e-9  # a yaw acceleration, and coarse steps, at the start
    assert max(free.values()) < smoothed
    states = 3e-4 if vessel == "response-2" else 1e-9  # its hidden state is differenced from the yaw rate
    assert max(value for name, value in found.items() if name.startswith("rmse_one")) < states


def test_a_long_free_run_of_the_truth_is_perfect():
    record = generate(Case("response-2", "zigzag:20/20"))
    found = prediction_scores(resolve("response-2"), [record])
    assert found["r2_free_heading_rad"] == pytest.approx(1.0, abs=1e-10)


def test_the_rudders_sign_in_the_record_does_not_matter():
    model, record = resolve("response-1"), generate(Case("response-1", "zigzag:20/20"))
    other = "port" if model.positive_rudder == "starboard" else "starboard"
    assert prediction_scores(model, [record.turned(other)]) == prediction_scores(model, [record])


def test_records_are_pooled_sample_by_sample(rng):
    model = resolve("response-1")
    records = [generate(Case("response-1", "zigzag:20/20", "medium", seed=int(rng.integers(99)))) for _ in range(2)]
    single = [prediction_scores(model, [record])["rmse_free_yaw_rate_rad_s"] for record in records]
    pooled = prediction_scores(model, records)["rmse_free_yaw_rate_rad_s"]
    assert pooled == pytest.approx(np.sqrt(np.mean(np.square(single))))


def test_gaps_are_left_out_of_both_horizons():
    model, record = resolve("response-1"), generate(Case("response-1", "zigzag:20/20"))
    holed = with_gaps(record, "yaw_rate_rad_s", "heading_rad", places=slice(100, 140))
    found = prediction_scores(model, [holed])
    assert found["rmse_free_heading_rad"] < 1e-9 and found["rmse_one_heading_rad"] < 1e-9
    (heading,) = [p for p in one_step(model, holed) if p.channel == "heading_rad"]
    observed, _ = heading.pair
    assert np.isfinite(observed).sum() == record.n - 1 - 41


def test_missing_rows_are_gaps_and_no_long_steps():
    model, record = resolve("response-1"), generate(Case("response-1", "zigzag:20/20"))
    keep = np.ones(record.n, bool)
    keep[200:230] = False
    cut = replace(record, time_s=record.time_s[keep], channels={k: v[keep] for k, v in record.channels.items()})
    found = prediction_scores(model, [cut])
    assert found["rmse_one_heading_rad"] < 1e-9


def test_heading_is_unwrapped():
    model = resolve("mariner")
    record = generate(Case("mariner", "turn:20"))
    wrapped = record.with_channels(heading_rad=np.angle(np.exp(1j * record.column("heading_rad"))))
    assert np.abs(np.diff(wrapped.column("heading_rad"))).max() > 6.0
    assert prediction_scores(model, [wrapped])["rmse_free_heading_rad"] < 1e-8


def test_positions_need_not_start_at_zero():
    record = generate(Case("mariner", "turn:20", duration_s=100.0))
    moved = record.with_channels(north_m=record.column("north_m") + 4000.0, east_m=record.column("east_m") - 500.0)
    assert prediction_scores(resolve("mariner"), [moved])["rmse_free_north_m"] < 1e-6


def test_an_unstable_model_is_flagged_as_diverged():
    model = resolve("response-1")
    record = generate(Case("response-1", "zigzag:20/20"))
    mild, wild = (model.with_coefficients([rate, model.coefficients[1], 0.0]) for rate in (0.05, 50.0))
    for unstable in (mild, wild):  # a run that has diverged stays where it was
        found = prediction_scores(unstable, [record])
        assert found["diverged"] and np.isfinite(found["rmse_free_heading_rad"])
    assert not prediction_scores(model, [record])["diverged"]


def test_a_record_without_any_state_cannot_be_scored():
    record = generate(Case("response-1", "zigzag:20/20")).with_channels(heading_rad=None, yaw_rate_rad_s=None)
    with pytest.raises(CannotFit):
        prediction_scores(resolve("response-1"), [record])
