"""Measured wind as an input of free runs."""

from dataclasses import replace

import numpy as np
import pytest

from helmbench.datasets.generator import Case, generate
from helmbench.diagnosis.free_runs.units import Lane
from helmbench.estimation.records.weather import measured_weather
from helmbench.models.model import resolve

from ...support.free_runs import blind_errors, whole_runs

SPEED, FROM = 3.0, np.deg2rad(60.0)


@pytest.fixture(scope="module")
def ship():
    return resolve("esso-osaka-l3")


@pytest.fixture(scope="module")
def record(ship):
    run = generate(Case(ship.id, "zigzag:20/20", disturbance=f"steady-wind:{SPEED}@60deg"))
    return run.with_channels(wind_speed_m_s=np.full(run.n, SPEED), wind_direction_rad=np.full(run.n, FROM))


def test_a_run_in_wind_is_predicted_with_the_measured_wind_and_not_without(ship, record):
    windy, calm = (whole_runs(model, [record]) for model in (ship, replace(ship, windage=None)))
    known, unknown = map(blind_errors, (windy, calm))
    assert np.all(known < 0.1 * windy.floor)
    assert np.all(unknown > 5.0 * windy.floor)


def test_weather_is_the_wind_towards_averaged_over_a_step(ship, record):
    weather = measured_weather(record, ship, record.time_s)
    towards = -SPEED * np.array([np.cos(FROM), np.sin(FROM)])
    assert weather.shape == (record.n, 7)
    assert weather[:, 2:4] == pytest.approx(np.tile(towards, (record.n, 1)))
    assert not weather[:, [0, 1, 4, 5, 6]].any()
    ramp = record.with_channels(wind_speed_m_s=record.time_s, wind_direction_rad=np.full(record.n, np.pi))
    every = record.time_s[::5]
    assert measured_weather(ramp, ship, every)[1:-1, 2] == pytest.approx(every[1:-1])


def test_gaps_are_bridged_and_wind_counts_only_where_it_is_known(ship, record):
    gap = record.column("wind_speed_m_s").copy()
    gap[10:50] = np.nan
    bridged = measured_weather(record.with_channels(wind_speed_m_s=gap), ship, record.time_s)
    assert bridged == pytest.approx(measured_weather(record, ship, record.time_s))
    none = record.with_channels(wind_speed_m_s=np.full(record.n, np.nan))
    assert measured_weather(none, ship, record.time_s) is None
    assert measured_weather(record.with_channels(wind_speed_m_s=None), ship, record.time_s) is None
    assert measured_weather(record, replace(ship, windage=None), record.time_s) is None


def test_validation_runs_in_the_measured_wind(ship, record):
    from helmbench.estimation.run.stretch import Stretch

    windy, calm = (Stretch.of(model, record).free_run().states for model in (ship, replace(ship, windage=None)))
    heading = record.heading_unwrapped()
    assert np.max(np.abs(windy[:, 5] - heading)) < 0.02 < np.max(np.abs(calm[:, 5] - heading))


def _gusty(record, ship, rng):
    """The ship in a wind that changes, its revolutions too: what is simulated with both as inputs."""
    from helmbench.models.simulate import simulate

    time = record.time_s
    size, turn = rng.uniform(6.0, 9.0), rng.choice([-1.0, 1.0]) * rng.uniform(1.0, 2.0)
    wind = size * (1.0 + 0.4 * np.sin(time / 7.0))
    direction = turn + 0.5 * np.sin(time / 11.0)
    turns = ship.n0_rps * (1.0 + 0.1 * np.sin(time / 13.0))
    changed = record.with_channels(wind_speed_m_s=wind, wind_direction_rad=direction, propeller_rps=turns)
    weather = measured_weather(changed, ship, time)
    start = np.zeros(len(ship.states))
    start[0] = record.column("surge_m_s")[0]
    states = simulate(ship, np.column_stack([record.rudder(), turns, weather]), record.dt, start)
    found = dict(zip(ship.states, states.T, strict=True))
    names = {"u": "surge_m_s", "v": "sway_m_s", "r": "yaw_rate_rad_s", "psi": "heading_rad"}
    names |= {"x": "north_m", "y": "east_m"}
    return changed.with_channels(**{names[s]: values for s, values in found.items() if s in names})


def test_filter_calibration_and_validation_give_the_same_free_run(ship, record, rng):
    """In wind and at revolutions that change; a calm run is far from all of them."""
    from helmbench.estimation.filters.innovations.estimator import estimator
    from helmbench.estimation.run.stretch import Stretch

    run = _gusty(record, ship, rng)
    heading = run.heading_unwrapped()

    def headings(model):
        est = estimator(model, [run])
        filtered = est.free_run(est.start(), 0, int(np.searchsorted(run.time_s, 5.0)))[:, 0]
        whole = whole_runs(model, [run])
        error = whole.errors([Lane(0, {}, whole.no_own[0])])[0][whole.symbols.index("psi"), 0]
        validated = Stretch.of(model, run).free_run().states[:, 5]
        return filtered, heading[whole.units[0].stretch.series.index] - error, validated

    late = run.time_s > 0.5 * run.time_s[-1]
    windy, calm = headings(ship), headings(replace(ship, windage=None))
    effect = min(float(np.std((heading - c)[late])) for c in calm)
    assert effect > np.deg2rad(1.5)
    for found in windy:
        assert np.max(np.abs((found - heading)[late])) < max(0.05 * effect, np.deg2rad(0.5))
