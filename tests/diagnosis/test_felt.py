"""Records without what causes explain: the rudder that acted, and current and wind among what was measured."""

import numpy as np
import pytest

import helmbench
from helmbench.diagnosis.felt import felt
from helmbench.estimation.filters.innovations.estimator import estimator
from helmbench.estimation.records.weather import measured_weather
from helmbench.models.model import resolve

FLOW = {"current_towards_north": 0.2, "current_towards_east": -0.1, "wind_towards_north": 3.0}


@pytest.fixture(scope="module")
def record():
    return helmbench.simulate("esso-osaka-l3", "zigzag:20/20", duration_s=40.0, dt_s=0.2)


def setting(record, **values):
    est = estimator(resolve("esso-osaka-l3"), [record])
    return est, est.with_entries(est.start(), values)


def test_nothing_is_changed_where_nothing_was_found(record):
    est, s = setting(record)
    (same,) = felt([record], est, s)
    assert same.channels.keys() == record.channels.keys()
    assert all(np.array_equal(same.column(name), record.column(name)) for name in record.channels)


def test_the_rudder_that_acted_and_the_channels_of_true_sensors(record):
    est, s = setting(record, rudder_delay=1.0, yaw_rate_bias=0.002, rudder_offset=0.01)
    (found,) = felt([record], est, s, kept=("rudder_offset",))
    late = np.interp(record.time_s - 1.0, record.time_s, record.rudder())
    assert found.rudder() == pytest.approx(late, abs=1e-9)
    assert found.column("yaw_rate_rad_s") == pytest.approx(record.column("yaw_rate_rad_s") - 0.002)


def test_flows_of_causes_are_added_to_the_measured_ones(record):
    est, s = setting(record, **FLOW)
    windy = record.with_channels(
        wind_speed_m_s=np.full(record.n, 2.0), wind_direction_rad=np.full(record.n, np.deg2rad(90.0))
    )
    (found,) = felt([windy], est, s)
    weather = measured_weather(found, resolve("esso-osaka-l3"), record.time_s)
    assert weather[:, :4] == pytest.approx(np.tile([0.2, -0.1, 3.0, -2.0], (record.n, 1)), abs=1e-9)
