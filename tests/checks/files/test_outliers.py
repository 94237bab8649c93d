"""Corners, steps and coarse steps of a motion are no gross errors; errors in them are."""

import numpy as np
import pytest

import helmbench
from helmbench.checks.check import check
from helmbench.checks.files.jumps import Splice
from helmbench.checks.files.outliers import Outliers
from helmbench.datasets.generator import Case, generate
from helmbench.datasets.record import Record
from helmbench.datasets.spikes import without_spikes


@pytest.mark.parametrize("ship", ["response-1", "response-2", "remus-kt", "patrol"])
@pytest.mark.parametrize("noise", ["none", "low"])
def test_corners_of_a_response_model_are_no_outliers(ship, noise, rng):
    """A first-order yaw rate has a corner where the rudder starts to move and where it stops."""
    for manoeuvre in ("zigzag:20/20", "steps:20deg/20s", "prbs:20deg/10s", "turn:20"):
        record = generate(Case(ship, manoeuvre, noise, seed=int(rng.integers(2**31))))
        assert not [f for f in check([record]).findings if f.cause == "outliers" and f.material], manoeuvre


def test_an_error_beside_a_corner_is_found_and_the_corner_kept(rng):
    t = np.arange(400.0)
    values = np.abs(t - 200.5) + 0.01 * rng.standard_normal(t.size)
    values[[100, 205, 300]] += [3.0, -4.0, 5.0]
    kept, found, _ = without_spikes(values)
    beside = set(np.flatnonzero(np.isnan(kept)).tolist()) - {100, 205, 300}
    assert found <= 7 and np.isnan(kept[[100, 205, 300]]).all() and all(194 < k < 209 for k in beside)


def test_errors_of_a_coarse_channel_are_found(rng):
    t = np.arange(600) * 0.5
    heading = np.round(0.5 * np.sin(t / 20.0) / 0.01) * 0.01
    at = rng.choice(np.arange(10, 590, 6), 6, replace=False)
    spoilt = heading.copy()
    spoilt[at] += rng.choice([-1.0, 1.0], 6)
    clean, wrong = (check([Record(t, {"heading_rad": h}, "run")]).findings for h in (heading, spoilt))
    assert "outliers" not in {f.cause for f in clean}
    assert any(f.cause == "outliers" and f.blanked == 6 for f in wrong)


def test_errors_that_bias_a_fit_are_warned_of(rng):
    record = generate(Case("response-1", "zigzag:20/20", "low", seed=int(rng.integers(2**31))))
    rate = record.column("yaw_rate_rad_s").copy()
    rate[rng.choice(np.arange(10, record.n - 10, 7), 8, replace=False)] += 20.0 * np.std(rate)
    with pytest.warns(helmbench.PlausibilityWarning, match="stand more than"):
        helmbench.identify(record.with_channels(yaw_rate_rad_s=rate), "nomoto-1", "ls")


def test_errors_at_both_ends_are_found_and_no_start_of_a_motion_is(rng):
    record = generate(Case("kvlcc2-l7", "zigzag:20/20", "low", seed=int(rng.integers(2**31))))
    for name in ("yaw_rate_rad_s", "surge_m_s", "sway_m_s", "heading_rad"):
        values = record.column(name).copy()
        assert without_spikes(values)[1] == 0
        at = [[0], [1], [-1], [-2], [0, 1], [0, -1]][rng.integers(6)]
        values[at] += rng.choice([-20.0, 20.0], len(at)) * np.std(values)
        assert np.array_equal(
            np.isnan(without_spikes(values)[0]), np.isin(np.arange(record.n), np.arange(record.n)[at])
        )


def test_errors_that_stand_apart_from_a_heavy_tail_are_found(rng):
    """Many near misses, as those of a sensor whose noise is not normal, do not hide what is far beyond them."""
    time = np.arange(500.0)
    speed = 5.0 + np.sin(time / 30.0) + 0.05 * rng.standard_normal(500)
    speed[20:490:10] += 12.0 * 0.05 * rng.choice([-1.0, 1.0], 47)
    at = [105, 106, 165, 225, 285, 345]
    speed[at] += rng.choice([-20.0, 20.0])
    (found,) = Outliers().find(Record(time, {"surge_m_s": speed}, "run"))
    assert found.material and np.isnan(found.columns["surge_m_s"][at]).all()


def test_heading_and_position_that_jump_in_the_same_row_are_two_runs_in_one(rng):
    record = generate(Case("mariner", "zigzag:10/10", "low", seed=int(rng.integers(2**31))))
    k, later = int(rng.integers(150, record.n - 150)), np.arange(record.n)
    moved = {
        name: record.column(name) + size * (later >= k) for name, size in (("heading_rad", 0.12), ("north_m", 80.0))
    }
    alone = record.with_channels(heading_rad=moved["heading_rad"])
    for changed, stands in ((alone, False), (record.with_channels(**moved), True)):
        found = [f for f in Splice().find(changed) if "heading_rad" in f.channels]
        assert [f.standing for f in found] == [stands]
