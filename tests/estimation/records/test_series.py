"""Records as arrays on a grid: noise levels, initial states, uneven samples, averages."""

import numpy as np
import pytest

from helmbench.datasets.record import Record
from helmbench.datasets.signals import sensor_sd
from helmbench.estimation.records.series import averaged, initial_state_of, series_of, speed_of, steps
from helmbench.models.errors import CannotFit
from helmbench.models.model import resolve

from ...made_up.records import driven


@pytest.mark.parametrize("sd", [1e-4, 1e-3, 1e-2])
def test_sensor_noise_is_estimated_from_the_record(rng, sd):
    model = resolve("response-1")
    rate = driven(model, 0.3 * np.sign(np.sin(0.02 * np.arange(5000))), 0.1).column("yaw_rate_rad_s")
    assert sensor_sd(rate) < 1e-6
    assert sensor_sd(rate + sd * rng.normal(size=5000)) == pytest.approx(sd, rel=0.1)


def test_outliers_and_gaps_hardly_move_it(rng):
    values = 1e-3 * rng.normal(size=40000)
    values[rng.integers(40000, size=400)] = np.nan
    values[rng.integers(40000, size=800)] += 1.0
    assert sensor_sd(values) == pytest.approx(1e-3, rel=0.15)


def test_a_coarse_sensor_is_not_noise_free():
    assert sensor_sd(np.round(np.sin(0.001 * np.arange(3000)), 1)) > 0.0


def test_too_few_samples_give_no_noise_estimate():
    assert sensor_sd(np.arange(8.0)) == 0.0


def test_initial_state_of_a_second_order_vessel():
    model = resolve("response-2")
    record = driven(model, 0.2 * np.ones(200), 0.1).slice(50, None)
    start, spread = initial_state_of(record, model)
    assert start[0] == 0.0 and spread[0] > 0.0
    assert start[1] == record.column("yaw_rate_rad_s")[0]
    assert start[2] == record.column("heading_rad")[0]
    only_heading, _ = initial_state_of(record.with_channels(yaw_rate_rad_s=None), model)
    assert only_heading[1] == pytest.approx(start[1], rel=0.05)


def test_unmeasured_surge_and_sway_start_on_a_straight_course():
    model = resolve("kvlcc2-l7")
    record = driven(model, 0.2 * np.ones(200), 0.2)
    start, spread = initial_state_of(record.with_channels(surge_m_s=None, sway_m_s=None), model)
    assert start[0] == model.speed_m_s and start[1] == 0.0
    assert spread[0] == spread[1] == pytest.approx(0.1 * model.speed_m_s)
    assert not spread[3:5].any()


def test_propeller_speed_is_the_set_value_where_it_is_not_recorded():
    model = resolve("kvlcc2-l7")
    record = driven(model, 0.2 * np.ones(50), 0.2)
    assert np.all(series_of(record, model).inputs[:, 1] == model.n0_rps)
    turning = record.with_channels(propeller_rps=np.linspace(9.0, 11.0, 50))
    assert series_of(turning, model).inputs[:, 1] == pytest.approx(np.linspace(9.0, 11.0, 50))


def test_input_gaps_are_bridged():
    model = resolve("response-1")
    record = driven(model, np.linspace(0.0, 0.2, 50), 0.1)
    rudder = record.rudder().copy()
    rudder[20:30] = np.nan
    assert series_of(record.with_channels(rudder_rad=rudder), model).inputs[:, 0] == pytest.approx(record.rudder())
    with pytest.raises(CannotFit, match="no samples"):
        series_of(record.with_channels(rudder_rad=np.full(50, np.nan)), model)


def test_missing_rows_keep_the_step():
    model = resolve("response-1")
    record = driven(model, np.linspace(0.0, 0.2, 100), 0.1)
    kept = np.r_[0:40, 45:60, 61:100]
    series = series_of(Record(record.time_s[kept], {k: v[kept] for k, v in record.channels.items()}), model)
    assert series.dt == pytest.approx(0.1)
    assert np.array_equal(series.index, kept) and not series.part.any()
    assert series.inputs[:, 0] == pytest.approx(record.rudder())


def test_uneven_samples_lie_between_grid_points(rng):
    model = resolve("response-1")
    time = np.cumsum(rng.uniform(0.05, 0.15, 200))
    channels = {"rudder_rad": 0.1 * time, "yaw_rate_rad_s": np.zeros(200)}
    series = series_of(Record(time, channels), model)
    grid = time[0] + series.dt * np.arange(len(series.inputs))
    assert series.observe(grid) == pytest.approx(time)
    assert series.inputs[:-1, 0] == pytest.approx(0.1 * grid[:-1], rel=1e-6)


def test_steps_are_equal_to_the_last_digit():
    record = Record(0.1 * np.arange(1000), {"rudder_rad": np.zeros(1000)})
    assert np.unique(steps(record)).size == 1


def test_the_speed_is_negative_astern():
    """A craft that drifts at 45 degrees, ahead and then astern, on a heading across north: by surge and sway, by
    positions, and by positions of which a heading is missing now and then; without a heading only its size is known."""
    t = 0.5 * np.arange(200)
    surge = np.where(t < 50.0, 2.0, -2.0)
    psi = np.full(t.size, -0.1)
    sway = surge * np.tan(np.pi / 4.0)
    track = np.cumsum(0.5 * np.column_stack(
        [surge * np.cos(psi) - sway * np.sin(psi), surge * np.sin(psi) + sway * np.cos(psi)]
    ), axis=0)  # fmt: skip
    places = {"rudder_rad": 0.0 * t, "north_m": track[:, 0], "east_m": track[:, 1]}
    expected = np.sqrt(2.0) * surge
    logged = Record(t, {"rudder_rad": 0.0 * t, "surge_m_s": surge, "sway_m_s": sway}, "log")
    np.testing.assert_allclose(speed_of(logged), expected)
    settled = np.abs(t - 50.0) > 5.0
    gappy = np.where(np.arange(t.size) % 3 == 0, psi, np.nan)
    for heading in (psi, gappy):
        tracked = Record(t, {**places, "heading_rad": heading}, "track")
        np.testing.assert_allclose(speed_of(tracked)[settled], expected[settled], rtol=1e-9)
    np.testing.assert_allclose(speed_of(Record(t, places, "track"))[settled], np.abs(expected[settled]), rtol=1e-9)


def test_averages_commute_with_linear_models():
    record = Record(
        0.1 * np.arange(1000),
        {"rudder_rad": np.arange(1000.0), "heading_rad": np.mod(0.01 * np.arange(1000), 2.0 * np.pi)},
    )
    mean = averaged(record, 100)
    assert mean.n == 100 and mean.dt == pytest.approx(1.0)
    assert mean.rudder() == pytest.approx(10.0 * np.arange(100) + 4.5)
    assert np.diff(mean.column("heading_rad")) == pytest.approx(0.1)
    assert averaged(record, 2000) is record
