"""Cramer-Rao bounds against published and computed values, and their general properties."""

from dataclasses import replace

import numpy as np
import pytest

from helmbench.datasets.generator import Case, generate
from helmbench.datasets.record import Record
from helmbench.estimation.information.bounds import cramer_rao
from helmbench.models.errors import BadInput, CannotFit
from helmbench.models.model import resolve

from ...made_up.records import driven
from ...simulators import paper_000

THREE_SINES = {
    "cargo": "heading:10deg/0.0105rad_s+6deg/0.031rad_s+4deg/0.083rad_s",
    "patrol": "heading:10deg/0.12rad_s+6deg/0.5rad_s+4deg/1.6rad_s",
}


@pytest.mark.parametrize(
    ("vessel", "manoeuvre", "duration", "expected"),
    [
        ("cargo", "heading:20deg/600s", 6000.0, (0.124, 5.95, 4.02, 0.0065)),
        ("cargo", THREE_SINES["cargo"], 6000.0, (0.0308, 0.839, 0.589, 0.0039)),
        ("patrol", "heading:20deg/0.27rad_s", 900.0, (0.757, 50.8, 81.5, 0.045)),
        ("patrol", THREE_SINES["patrol"], 900.0, (0.135, 7.47, 11.9, 0.0075)),
    ],
    ids=["cargo S1", "cargo S3", "patrol S1", "patrol S3"],
)
def test_published_bounds_of_paper_003(vessel, manoeuvre, duration, expected):
    """Heading noise 1e-3 rad, dt 0.02 s, the first 60 %, initial state known: T1, T2, T3, K in per cent."""
    model = resolve(vessel)
    record = generate(Case(vessel, manoeuvre, duration_s=duration, dt_s=0.02))
    record = record.slice(0, int(0.6 * record.n))
    sd, _ = cramer_rao(model, [record], {"heading_rad": 1e-3}, initial_states=False)
    assert 100.0 * sd / np.abs(model.to_parameters(model.coefficients)) == pytest.approx(expected, rel=0.015)


def test_continuous_bound_of_paper_000():
    """0.1 deg of heading noise at 0.1 s, rudder steps: a fine grid whose other samples are gaps."""
    h = 1e-3
    time, heading = h * np.arange(20001), np.full(20001, np.nan)
    heading[::100] = 0.0
    rudder = np.zeros(20001)
    for side, start in zip((1, -1) * 5, paper_000.SWITCHES_CONTINUOUS, strict=True):
        rudder[round(start / h) :] = side * np.deg2rad(20.0)
    record = Record(time, {"rudder_rad": rudder, "heading_rad": heading})
    sd, _ = cramer_rao(resolve("remus-kt"), [record], {"heading_rad": np.deg2rad(0.1)}, initial_states=False)
    found = dict(zip(("T1", "T2", "K", "T3"), sd, strict=True))
    assert paper_000.in_paper_order(found) == pytest.approx(paper_000.BOUND_CONTINUOUS, rel=5e-3)


def test_mariner_zigzag_identifies_few_coefficients():
    """15/15 zigzag at model scale, .01 m/s and .05 deg/s at 10 Hz: few of 40 coefficients, as published."""
    model = resolve("mariner-model")
    record = generate(Case("mariner-model", "zigzag:15/15:port", duration_s=120.0, dt_s=0.1))
    noise = {"surge_m_s": 0.01, "sway_m_s": 0.01, "yaw_rate_rad_s": np.deg2rad(0.05)}
    sd, _ = cramer_rao(model, [record], noise)
    truth = model.coefficients
    relative = (sd / np.abs(np.where(truth, truth, np.nan)))[truth != 0.0]
    counts = [np.sum(relative < 0.1), np.sum((relative >= 0.1) & (relative < 0.5)), np.sum(relative >= 0.5)]
    assert np.abs(np.array(counts) - [1, 3, 36]).max() <= 1, counts


@pytest.fixture
def case():
    model = resolve("response-2")
    rudder = 0.3 * np.sign(np.sin(0.05 * np.arange(1500)))
    return model, driven(model, rudder, 0.1)


NOISE = {"yaw_rate_rad_s": 1e-3, "heading_rad": 2e-3}


def test_scaling(case):
    model, record = case
    sd, covariance = cramer_rao(model, [record], NOISE)
    tripled, _ = cramer_rao(model, [record], {k: 3.0 * v for k, v in NOISE.items()})
    assert tripled == pytest.approx(3.0 * sd, rel=1e-9)
    twice, _ = cramer_rao(model, [record, record], NOISE)
    assert twice == pytest.approx(sd / np.sqrt(2.0), rel=1e-9)
    jacobian = model.parameters_jacobian(model.coefficients)
    assert sd == pytest.approx(np.sqrt(np.diag(jacobian @ covariance @ jacobian.T)))


def test_information_only_helps(case):
    model, record = case
    sd, _ = cramer_rao(model, [record], NOISE)
    known, _ = cramer_rao(model, [record], NOISE, initial_states=False)
    less, _ = cramer_rao(model, [record], {"heading_rad": 2e-3})
    values = record.column("yaw_rate_rad_s").copy()
    values[::2] = np.nan
    gaps, _ = cramer_rao(model, [record.with_channels(yaw_rate_rad_s=values)], NOISE)
    assert np.all(known <= sd * (1 + 1e-9)) and np.all(sd < gaps) and np.all(gaps < less)


def test_against_finite_differences(case):
    """Fisher information from simulations with every coefficient changed a little."""
    from helmbench.models.simulate import initial_state, inputs_of, simulate

    model, record = case
    _, covariance = cramer_rao(model, [record], NOISE, initial_states=False)

    def outputs(coefficients):
        moved = model.with_coefficients(coefficients)
        states = simulate(moved, inputs_of(model, record.rudder()), 0.1, _steady_turn(moved, record))
        return np.concatenate([states[:, 1] / 1e-3, states[:, 2] / 2e-3])

    def _steady_turn(moved, record):
        start = initial_state(moved)
        start[0] -= moved.coefficients[model.kernels.RATE_GAIN] * record.rudder()[0]
        return start

    columns = []
    for i, value in enumerate(model.coefficients):
        step = np.zeros(model.coefficients.size)
        step[i] = 1e-5 * abs(value)
        columns.append((outputs(model.coefficients + step) - outputs(model.coefficients - step)) / (2.0 * step[i]))
    information = np.array(columns) @ np.array(columns).T
    assert covariance == pytest.approx(np.linalg.inv(information), rel=1e-4)


def test_what_is_not_excited_has_an_infinite_bound():
    model = resolve("response-1")
    straight = driven(model, np.zeros(300), 0.1)
    sd, covariance = cramer_rao(model, [straight], NOISE, initial_states=False)
    assert np.isinf(sd).all() and np.isinf(np.diag(covariance)).all()
    still = cramer_rao(model, [straight, driven(model, np.full(300, 0.2), 0.1)], NOISE)[0]
    assert np.isfinite(still).all()


def test_refusals(case):
    model, record = case
    with pytest.raises(CannotFit, match="unknown coefficients"):
        cramer_rao(model.blanked(), [record], NOISE)
    with pytest.raises(BadInput, match="'rudder_rad' is not that of a state"):
        cramer_rao(model, [record], {"rudder_rad": 1.0})
    with pytest.raises(BadInput, match="positive"):
        cramer_rao(model, [record], {"heading_rad": 0.0})
    diverging = replace(model, coefficients=model.coefficients * [-500.0, 1.0, 1.0, 1.0, 1.0])
    with pytest.raises(CannotFit, match="diverges"):
        cramer_rao(diverging, [record], NOISE)
