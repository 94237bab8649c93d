"""The S175 in both structures against reference values of an independent implementation (RK4, 0.02 s)."""

import numpy as np
import pytest

from helmbench.datasets import indices
from helmbench.datasets.generator import Case, generate
from helmbench.models.model import resolve
from helmbench.models.simulate import accelerations, initial_state, inputs_of

DEGREE = np.pi / 180

ACCELERATIONS = {
    "s175": [0.006603917739385657, -0.04249897044091633, -0.0006373167766926893],
    "s175-polynomial": [0.006603917739385662, -0.04505116739451091, -0.0007316612257440993],
}

# vessel, manoeuvre: first three overshoots [deg], time of the second execute and of the first heading extreme [s]
ZIGZAGS = {
    ("s175", "zigzag:10/10"): (3.303, 4.022, 3.985, 44.42, 59.40),
    ("s175", "zigzag:20/20"): (5.629, 5.304, 5.168, 48.98, 63.54),
    ("s175-polynomial", "zigzag:10/10"): (3.364, 4.347, 4.360, 45.84, 62.00),
    ("s175-polynomial", "zigzag:20/20"): (5.940, 6.040, 5.970, 50.16, 65.94),
}

# vessel, manoeuvre: advance, transfer, t90, tactical diameter, t180, max advance, max transfer, steady radius,
# steady speed, yaw rate [deg/s], sway and drift angle [deg]
TURNS = {
    ("s175", "turn:10"): "1045.256 727.696 192.708 1582.272 375.111 1050.1 1587.149 763.742 6.522 .489 .736 6.482",
    ("s175", "turn:20"): "750.208 483.112 143.32 1073.605 286.903 756.613 1080.074 493.794 5.29 .614 .854 9.292",
    ("s175", "turn:35"): "599.341 345.138 122.136 761.227 250.904 607.114 768.903 308.805 3.653 .678 .803 12.701",
    ("s175-polynomial", "turn:10"): (
        "1051.253 709.377 191.589 1526.174 366.673 1056.347 1531.409 716.143 6.388 .511 .773 6.954"
    ),
    ("s175-polynomial", "turn:20"): (
        "745.68 455.538 139.829 993.17 272.372 752.854 1000.917 416.067 4.848 .668 .945 11.246"
    ),
    ("s175-polynomial", "turn:35"): (
        "586.014 307.475 115.549 659.127 227.746 595.864 670.794 217.775 2.926 .770 .966 19.266"
    ),
}

# MSS container.m with roll locked: overshoots [deg] of a zigzag; advance, transfer, tactical diameter, steady radius
LITERAL = {
    "zigzag:10/10": (3.336, 4.048, 4.010),
    "zigzag:20/20": (5.614, 5.356, 5.167),
    "turn:10": (1046.14, 729.40, 1585.36, 765.49),
    "turn:20": (750.42, 484.12, 1074.86, 494.62),
}


@pytest.mark.parametrize("vessel", ACCELERATIONS)
def test_accelerations_at_a_point(vessel):
    model = resolve(vessel)
    state = [7.5, 0.4, 0.4 * DEGREE, 0.0, 0.0, 0.0]
    rates = accelerations(model, [state], inputs_of(model, [10.0 * DEGREE]))[0]
    np.testing.assert_allclose(rates[:3], ACCELERATIONS[vessel], rtol=1e-9)


@pytest.mark.parametrize("vessel", ACCELERATIONS)
def test_the_propeller_holds_the_approach_speed(vessel):
    model = resolve(vessel)
    assert model.n0_rps == pytest.approx(1.2733775613223017, rel=1e-12)
    rates = accelerations(model, [initial_state(model)], inputs_of(model, [0.0]))[0]
    np.testing.assert_allclose(rates[:3], 0.0, atol=1e-12)


@pytest.mark.parametrize(("vessel", "text"), ZIGZAGS)
def test_zigzag(vessel, text):
    *overshoots, second_execute_s, first_extreme_s = ZIGZAGS[vessel, text]
    record = generate(Case(vessel, text, duration_s=400.0, dt_s=0.02))
    np.testing.assert_allclose(np.rad2deg(indices.overshoots(record)[:3]), overshoots, atol=0.03)
    executes = indices.execute_times(record)
    np.testing.assert_allclose(executes[:2], [10.0, second_execute_s], atol=0.1)
    assert indices.overshoot_times(record)[0] == pytest.approx(first_extreme_s, abs=0.1)


@pytest.mark.parametrize(("vessel", "text"), TURNS)
def test_turn(vessel, text):
    expected = [float(number) for number in TURNS[vessel, text].split()]
    record = generate(Case(vessel, text, duration_s=1600.0, dt_s=0.02))
    found = indices.turning_indices(record, 10.0)
    names = ["advance", "transfer", "tactical_diameter", "max_advance", "max_transfer", "steady_radius"]
    np.testing.assert_allclose([found[n] for n in names], [expected[i] for i in (0, 1, 3, 5, 6, 7)], rtol=1e-4)
    np.testing.assert_allclose([found["t90"], found["t180"]], [expected[2], expected[4]], atol=0.1)
    sway = abs(record.column("sway_m_s")[-1])
    np.testing.assert_allclose([found["steady_speed"], sway], [expected[8], expected[10]], atol=6e-4)
    assert np.rad2deg(found["steady_yaw_rate"]) == pytest.approx(expected[9], abs=6e-4)
    assert np.rad2deg(found["drift_angle"]) == pytest.approx(expected[11], abs=2e-3)


@pytest.mark.parametrize("text", LITERAL)
def test_instantaneous_variant_stays_close_to_the_published_program(text):
    """The hull terms u'v', u'r' of paper 004 (v', r' in the program) make 0.3 % and 0.06 deg."""
    kind = text.split(":")[0]
    record = generate(Case("s175", text, duration_s=400.0 if kind == "zigzag" else 1600.0, dt_s=0.02))
    if kind == "zigzag":
        np.testing.assert_allclose(np.rad2deg(indices.overshoots(record)[:3]), LITERAL[text], atol=0.06)
    else:
        found = indices.turning_indices(record, 10.0)
        names = ("advance", "transfer", "tactical_diameter", "steady_radius")
        np.testing.assert_allclose([found[name] for name in names], LITERAL[text], rtol=3e-3)
