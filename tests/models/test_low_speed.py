"""MMG models at rest, at low speed and with varying revolutions."""

import numpy as np
import pytest
import sympy as sp
from scipy.integrate import quad

from helmbench.models.kernels import definition_of
from helmbench.models.model import resolve
from helmbench.models.primitives import absv
from helmbench.models.simulate import accelerations, inputs_of, simulate, state_matrices

SHIPS = ("kvlcc2-l7", "esso-osaka-l3")
DT = 0.2


@pytest.mark.parametrize("name", SHIPS)
@pytest.mark.parametrize("revolutions", [0.0, 8.0])
def test_rates_and_their_derivatives_are_finite_at_rest(name, revolutions):
    model, rest = resolve(name), np.zeros(6)
    inputs = inputs_of(model, np.zeros(1), propeller=revolutions)
    assert np.isfinite(accelerations(model, rest[None], inputs)).all()
    a, b = state_matrices(model, rest, inputs[0])
    assert np.isfinite(a).all() and np.isfinite(b).all()


@pytest.mark.parametrize("name", SHIPS)
def test_a_ship_starts_from_rest_and_stays_there_without_revolutions(name):
    model, rest = resolve(name), np.zeros(6)
    still = simulate(model, inputs_of(model, np.full(501, 0.3), propeller=0.0), DT, rest)
    assert np.max(np.abs(still)) < 1e-3
    away = simulate(model, inputs_of(model, np.zeros(501), propeller=model.n0_rps), DT, rest)
    assert 0.3 * model.speed_m_s < away[-1, 0] < 1.05 * model.speed_m_s
    assert np.all(np.diff(away[:, 0]) > 0.0)


def test_steady_speed_is_proportional_to_the_revolutions():
    model = resolve("esso-osaka-l3")
    ends = [
        simulate(model, inputs_of(model, np.zeros(10001), propeller=n), DT, np.zeros(6))[-1, 0] for n in (8.0, 12.0)
    ]
    assert ends[1] / ends[0] == pytest.approx(1.5, rel=1e-3)
    assert ends[1] == pytest.approx(model.speed_m_s, rel=1e-2)


def test_a_reversed_propeller_stops_the_ship_and_drives_it_astern():
    model = resolve("esso-osaka-l3")
    start = np.array([0.4, 0.0, 0.0, 0.0, 0.0, 0.0])
    run = simulate(model, inputs_of(model, np.zeros(1001), propeller=-10.0), DT, start)
    assert np.isfinite(run).all() and run[-1, 0] < -0.05


def test_a_turn_on_the_spot_and_a_drift_across_are_regular():
    model = resolve("esso-osaka-l3")
    states = np.array([[0.0, 0.0, 0.05, 0, 0, 0], [0.0, 0.2, 0.0, 0, 0, 0], [1e-9, -1e-9, 0.02, 0, 0, 0]])
    rates = accelerations(model, states, inputs_of(model, np.zeros(3), propeller=0.0))
    assert np.isfinite(rates).all()
    assert rates[0, 2] < 0.0 and rates[1, 1] < 0.0


@pytest.mark.parametrize(("v", "turn"), [(0.2, 0.1), (-0.05, 0.3), (0.0, 0.2), (0.1, -0.4)])
def test_cross_flow_drag_is_the_integral_over_the_hull(v, turn):
    definition = definition_of("mmg-low-speed")
    numbers = {symbol: 0.0 for symbol in [*definition.states, *definition.parameters, *definition.helpers]}
    known = {symbol.name: symbol for symbol in numbers}
    given = {"v": v, "rL": turn, "C_rY": 2.2, "C_rN": 0.8, "C_D": 1.0, "L": 1.0, "d": 1.0}
    numbers |= {known[name]: value for name, value in given.items()}
    for symbol, expression in definition.helpers.items():
        if symbol.name.startswith("cross_"):
            numbers[symbol] = float(expression.xreplace(numbers))
    for force, lever, power in zip(definition.forces[1:], (2.2, 0.8), (0, 1), strict=True):
        value = -float(force.xreplace(numbers).replace(absv, sp.Abs))
        flow = lambda x, c=lever, p=power: abs(v + c * turn * x) * (v + c * turn * x) * x**p  # noqa: E731
        assert value == pytest.approx(quad(flow, -0.5, 0.5)[0], abs=2e-3 * (abs(v) + abs(lever * turn)) ** 2)
