"""Discretised linear systems, their response and their noise."""

import numpy as np
import pytest

from helmbench.estimation.observers.linear import discretised, noise_gains, respond


@pytest.mark.parametrize("hold", ["zero", "linear", "euler"])
def test_a_double_integrator_under_each_hold(hold):
    system = discretised([[0.0, 1.0], [0.0, 0.0]], [[0.0], [1.0]], 0.5, hold)
    states = respond(system, np.array([[0.0], [2.0], [4.0]]), [0.0, 0.0])
    position = {"zero": 0.25, "linear": 2.0 / 3.0, "euler": 0.0}[hold]
    velocity = {"zero": 1.0, "linear": 2.0, "euler": 1.0}[hold]
    assert states[2] == pytest.approx([position, velocity], rel=1e-13, abs=1e-15)


def test_unknown_hold_is_refused():
    with pytest.raises(ValueError, match="unknown hold"):
        discretised([[0.0]], [[1.0]], 1.0, "cubic")


def test_noise_gain_of_a_mean_and_of_no_stable_system():
    a = 0.9
    system = discretised([[np.log(a)]], [[1.0]], 1.0, "zero")
    expected = abs(system.now[0, 0]) / np.sqrt(1.0 - a**2)
    assert noise_gains(system)[0] == pytest.approx(expected, rel=1e-12)
    with pytest.raises(ValueError, match="not stable"):
        noise_gains(discretised([[0.1]], [[1.0]], 1.0, "zero"))


def test_noise_gains_are_those_of_a_long_run(rng):
    system = discretised([[-1.0, 0.3], [0.0, -2.0]], [[0.5], [1.0]], 0.4, "linear")
    states = respond(system, rng.normal(size=(200_000, 1)), np.zeros(2))
    assert states[100:].std(axis=0) == pytest.approx(noise_gains(system), rel=0.03)
