"""The equations have the derivatives that are stated, and so have the features of time."""

import numpy as np
import pytest

from helmbench.methods.pinn import PinnEquations, features_of
from helmbench.models.model import resolve


def test_the_slopes_of_the_features_are_their_derivatives(rng):
    """Central differences of a thousandth of a step; between two points of the grid, where the features are smooth but
    for the interpolation of the integrals, whose error is the curvature of an input's power within a step."""
    inputs = np.cumsum(rng.normal(size=(101, 1)), axis=0) / 100.0
    window, place, dt, step = (20, 80, 24), rng.uniform(21.0, 79.0, 50), 0.5, 1e-3
    place = np.floor(place) + 0.1 + 0.8 * (place % 1.0)
    at = features_of(window, dt, inputs, place)
    low, high = (features_of(window, dt, inputs, place + side * step).values for side in (-1.0, 1.0))
    change = (high - low) / (2.0 * step * dt)
    smooth = 24 + 1
    assert np.abs(at.slopes - change)[:, :smooth].max() < 1e-5
    assert np.abs(at.slopes - change)[:, smooth:].max() < np.abs(np.diff(inputs, axis=0)).max() * 3.0


def test_the_derivatives_are_those_of_the_rates(rng):
    """Central differences of 1e-5, of a model with a product of two coefficients."""
    model = resolve("remus-kt")
    equations, theta = PinnEquations.of(model.blanked()), model.coefficients
    x, u, step = rng.normal(size=(250, 3)), rng.normal(size=(250, 1)), 1e-5
    rates, by_state, by_theta = equations.derivatives(x, u, theta)
    assert rates == pytest.approx(equations.rates(x, u, theta), rel=1e-12, abs=1e-12)
    for k, move in enumerate(step * np.eye(3)):
        change = (equations.rates(x + move, u, theta) - equations.rates(x - move, u, theta)) / (2.0 * step)
        assert by_state[:, :, k] == pytest.approx(change, abs=1e-8)
    for k, move in enumerate(step * np.eye(4)):
        change = (equations.rates(x, u, theta + move) - equations.rates(x, u, theta - move)) / (2.0 * step)
        assert by_theta[:, :, k] == pytest.approx(change, abs=1e-8)
