"""Gains of runs against sums worked out by hand."""

from dataclasses import replace

import numpy as np
import pytest

from helmbench.datasets.generator import Case, generate
from helmbench.diagnosis.gain.runs import Pair, gain_of, own_run, pairs_of
from helmbench.estimation.run.run import Measured, Run, run_along
from helmbench.estimation.run.stretch import Stretch
from helmbench.models.extend import extended
from helmbench.models.model import resolve

from ...made_up.records import errors_of, long_zigzag


def made_up(name, seen, error, places):
    """A run whose surge is off by an error."""
    measured = Measured(name, np.arange(seen.size, dtype=float), np.zeros(seen.size), {"surge_m_s": seen})
    return Run("m", measured, {"surge_m_s": seen - error}, places, ())


def test_a_gain_is_the_ratio_of_the_pooled_errors(rng):
    places = (slice(0, 150), slice(160, 400))
    pairs, errors = [], []
    for name in ("one", "two"):
        seen, error = np.sin(0.02 * np.arange(400.0)), rng.normal(size=400)
        runs = [made_up(name, seen, share * error, places) for share in (1.0, 0.1, 0.5, 0.05)]
        pairs.append(Pair(*runs, block=10))
        errors += [error[place] for place in places]
    gain = gain_of(pairs, rng)["surge_m_s"]
    rms = float(np.sqrt(np.mean(np.concatenate(errors) ** 2)))
    assert [gain.rmse_before, gain.rmse_after] == pytest.approx([rms, 0.1 * rms])
    assert [gain.own_before, gain.own_after] == pytest.approx([0.5 * rms, 0.05 * rms])
    assert 0.05 < gain.ratio_low < 0.1 + 1e-9 and 0.1 - 1e-9 < gain.ratio_high < 0.2
    assert gain.closed == pytest.approx(0.99, abs=1e-3) and gain.r2_before < gain.r2_after


def test_a_held_out_record_is_run_with_what_belongs_to_it():
    """A current of the record's own, not the mean over the training records."""
    ship = resolve("mariner")
    record = generate(Case("mariner", "zigzag:20/20", disturbance="current:0.5@90deg", duration_s=200.0))
    still = extended(ship, "current")
    own = {record.name: {"current_towards_north": 0.0, "current_towards_east": 0.5}}
    (lost,), (known,) = (pairs_of(ship, still, [record], values, own=False) for values in ({}, own))
    errors = [pair.after.squares()["east_m"].scores()[0] for pair in (lost, known)]
    assert errors[1] < 0.05 * errors[0]


def test_a_record_that_no_model_can_run_along_has_no_gain(rng):
    ship = resolve("mariner")
    record = generate(Case("mariner", "zigzag:20/20", duration_s=100.0))
    blind = replace(record, channels={"rudder_rad": record.rudder()})
    assert gain_of(pairs_of(ship, ship, [blind], {}), rng) == {}


# ---- Runs with a record's own neutral rudder angle and start.


@pytest.fixture(scope="module")
def ship():
    return resolve("mariner")


@pytest.fixture(scope="module")
def record():
    return long_zigzag()


def test_a_neutral_angle_of_the_record_is_its_own(ship, record):
    """Half a degree of trim turns a model's heading away; with an angle of the record's own nothing is left of it."""
    trimmed = record.with_channels(rudder_rad=record.column("rudder_rad") + np.deg2rad(0.5))
    exact, blind, own = (
        errors_of(run_along(ship, one, by=by))
        for one, by in ((record, own_run), (trimmed, Stretch.free_run), (trimmed, own_run))
    )
    assert blind["heading_rad"] > 20.0 * exact["heading_rad"]
    assert own["heading_rad"] < 2.0 * exact["heading_rad"]


def test_a_wrong_model_is_not_excused_by_the_records_own_start(ship, record):
    wrong = ship.with_coefficients(ship.coefficients * np.where(np.array(ship.coordinates) == "Nd", 0.8, 1.0))
    blind, own = (errors_of(run_along(wrong, record, by=by))["yaw_rate_rad_s"] for by in (Stretch.free_run, own_run))
    assert own > 0.7 * blind > 5.0 * errors_of(run_along(ship, record))["yaw_rate_rad_s"]


def test_an_own_start_is_that_of_the_fit_also_where_records_are_sampled_finely(ship, seed):
    """A fit sees fewer samples, whose smoothed start differs."""
    fine = generate(Case("mariner", "zigzag:20/20", "high", seed=seed, duration_s=500.0, dt_s=0.25))
    blind, own = (errors_of(run_along(ship, fine, by=by))["heading_rad"] for by in (Stretch.free_run, own_run))
    assert own < 0.9 * blind
