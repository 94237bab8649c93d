"""The Mariner against reference values of an independent implementation (RK4, 0.01 s; overshoots +-0.02 deg)."""

from dataclasses import replace

import numpy as np
import pytest

from helmbench.datasets import indices
from helmbench.datasets.generator import record_run
from helmbench.datasets.manoeuvres import parse_manoeuvre
from helmbench.models.model import RudderGear, resolve
from helmbench.models.simulate import accelerations

DEGREE = np.pi / 180

# manoeuvre: first three overshoots [deg], time of the second execute and of the first heading extreme [s]
ZIGZAGS = {
    "zigzag:10/10:port": (3.459, 6.193, 4.460, 46.38, 60.86),
    "zigzag:10/10": (4.902, 4.456, 6.175, 38.83, 58.49),
    "zigzag:15/15:port": (5.279, 6.812, 5.505, 46.49, 61.84),
    "zigzag:15/15": (6.525, 5.563, 6.745, 41.17, 59.63),
    "zigzag:20/20:port": (6.712, 7.277, 6.236, 47.82, 63.72),
    "zigzag:20/20": (7.787, 6.315, 7.205, 43.50, 61.54),
    "zigzag:30/30:port": (8.694, 8.244, 7.438, 52.72, 70.22),
    "zigzag:30/30": (9.574, 7.514, 8.163, 49.16, 67.99),
}

# manoeuvre, execute [s]: advance, transfer, t90, tactical diameter, t180, max advance, max transfer, steady radius,
# steady speed, yaw rate [deg/s], sway and drift angle [deg]
TURNS = {
    ("turn:15:port", 100): "946.274 539.587 176.062 1310.923 341.685 955.92 1315.156 711.247 6.629 .534 .676 5.849",
    ("turn:20:port", 100): "827.967 471.541 156.824 1174.432 311.556 838.315 1178.863 645.343 6.418 .570 .705 6.310",
    ("turn:35:port", 100): "682.414 393.722 136.348 1027.026 283.903 690.561 1031.267 575.666 6.040 .601 .722 6.863",
    ("turn:15", 100): "642.79 593.143 129.01 1311.303 283.768 656.475 1316.023 665.387 6.549 .564 .693 6.078",
    ("turn:20", 100): "578.502 532.311 117.152 1195.738 263.394 592.98 1200.581 613.183 6.359 .594 .717 6.479",
    ("turn:35", 100): "491.465 454.245 103.141 1060.173 244.286 503.192 1064.529 555.721 6.009 .620 .729 6.968",
    ("turn:35:port", 0): "596.743 439.597 121.588 1070.336 268.352 606.341 1074.623 575.666 6.04 .601 .722 6.863",
    ("turn:35", 0): "570.179 420.231 116.154 1029.216 258.26 580.135 1033.508 555.721 6.009 .620 .729 6.968",
}


def sail(text, duration_s, dt_s, execute_s=10.0, rudder=None):
    model = resolve("mariner")
    changed = replace(model, suite={**model.suite, "execute_s": execute_s}, rudder=rudder or model.rudder)
    return record_run(changed, parse_manoeuvre(text), duration_s=duration_s, dt_s=dt_s)


def check_zigzag(record, overshoots, second_execute_s=None, first_extreme_s=None):
    found = np.rad2deg(indices.overshoots(record)[:3])
    np.testing.assert_allclose(found, overshoots, atol=0.02)
    executes = indices.execute_times(record)
    assert executes[0] == pytest.approx(10.0)
    if second_execute_s is not None:
        assert executes[1] == pytest.approx(second_execute_s, abs=0.1)
    if first_extreme_s is not None:
        assert indices.overshoot_times(record)[0] == pytest.approx(first_extreme_s, abs=0.1)


def test_accelerations_at_a_point():
    state = [7.0, 0.5, -0.5 * DEGREE, 0.0, 0.0, 0.0]
    rates = accelerations(resolve("mariner"), [state], [[15.0 * DEGREE]])[0]
    expected = [-0.0003463563440256612, 0.010209002395507783, -0.00015637338117676684]
    np.testing.assert_allclose(rates[:3], expected, rtol=1e-9)


def test_accelerations_scale_to_the_model():
    full, small = resolve("mariner"), resolve("mariner-model")
    length, speed = (small.particulars["L"] / full.particulars["L"], small.speed_m_s / full.speed_m_s)
    state = np.array([7.0, 0.5, -0.01])
    there = accelerations(full, [[*state, 0, 0, 0]], [[0.2]])[0, :3]
    here = accelerations(small, [[*(state * [speed, speed, speed / length]), 0, 0, 0]], [[0.2]])[0, :3]
    scale = speed**2 / length * np.array([1.0, 1.0, 1.0 / length])
    np.testing.assert_allclose(here, there * scale, rtol=1e-9)


@pytest.mark.parametrize("text", ZIGZAGS)
def test_zigzag(text):
    *overshoots, second_execute_s, first_extreme_s = ZIGZAGS[text]
    check_zigzag(sail(text, 400.0, 0.01), overshoots, second_execute_s, first_extreme_s)


def test_zigzag_with_a_slow_rudder_without_lag():
    gear = RudderGear(40.0 * DEGREE, 2.5 * DEGREE, 0.0)
    check_zigzag(sail("zigzag:20/20:port", 400.0, 0.01, rudder=gear), (9.603, 9.891, 8.569), 49.76, 70.55)


@pytest.mark.parametrize(("text", "execute_s"), TURNS)
def test_turn(text, execute_s):
    """Transfers count from the approach line: the ship has drifted 33.8 m off it when it executes at 100 s."""
    expected = [float(number) for number in TURNS[text, execute_s].split()]
    record = sail(text, 1600.0, 0.02, execute_s)
    found = indices.turning_indices(record, execute_s)
    names = ["advance", "transfer", "tactical_diameter", "max_advance", "max_transfer", "steady_radius"]
    np.testing.assert_allclose([found[n] for n in names], [expected[i] for i in (0, 1, 3, 5, 6, 7)], rtol=1e-4)
    np.testing.assert_allclose([found["t90"], found["t180"]], [expected[2], expected[4]], atol=0.1)
    sway = abs(record.column("sway_m_s")[-1])
    np.testing.assert_allclose([found["steady_speed"], sway], [expected[8], expected[10]], atol=6e-4)
    assert np.rad2deg(found["steady_yaw_rate"]) == pytest.approx(expected[9], abs=6e-4)
    assert np.rad2deg(found["drift_angle"]) == pytest.approx(expected[11], abs=2e-3)


def test_drift_with_the_rudder_amidships():
    record = sail("straight", 100.0, 0.01)
    last = [record.column(name)[-1] for name in ("heading_rad", "yaw_rate_rad_s", "east_m", "sway_m_s")]
    assert np.rad2deg(last[0]) == pytest.approx(8.059, abs=6e-4)
    assert np.rad2deg(last[1]) == pytest.approx(0.12478, abs=6e-6)
    assert last[2] == pytest.approx(33.832, abs=6e-4)
    assert last[3] == pytest.approx(-0.14849, abs=6e-6)
