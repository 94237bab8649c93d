"""The equations as jax has them are the model's, and the features of time have the slopes that are stated."""

import numpy as np
import pytest

from helmbench.estimation.methods_only.black_box.free_runs import require_jax
from helmbench.estimation.methods_only.physics_informed.equations import PinnEquations, rates_of
from helmbench.estimation.methods_only.physics_informed.fit import features_of
from helmbench.models.kernels import catalogue
from helmbench.models.model import list_vessels, resolve
from helmbench.models.simulate import accelerations


def one_of_each_family():
    """A vessel of every family that has one, and the response families, which need no constants."""
    vessels = [resolve(name) for name in list_vessels()]
    found = {model.family: model for model in vessels}
    rest = [name for name, facts in catalogue().items() if name not in found and not facts["constants"]]
    return [*found.values(), *map(resolve, rest)]


@pytest.mark.parametrize("model", one_of_each_family(), ids=lambda model: model.family)
def test_the_equations_are_those_of_the_compiled_kernels(model, rng):
    """To rounding, at coefficients and states that no ship need have; relative to each state's largest rate."""
    known = np.where(np.isfinite(model.coefficients), model.coefficients, 1.0)
    model = model.with_coefficients(known * rng.uniform(0.5, 1.5, known.size) + 1e-3 * rng.normal(size=known.size))
    x, u = rng.normal(size=(20, len(model.states))), rng.uniform(0.2, 1.0, (20, len(model.inputs)))
    x[:, 0] += 5.0 * ("u" in model.states)
    jax = require_jax()
    with jax.enable_x64(True):
        found = np.asarray(jax.vmap(rates_of(model.family), (0, 0, None))(x, u, model.theta))
    expected = accelerations(model, x, u)
    assert np.isfinite(expected).all()
    assert np.all(np.abs(found - expected) <= 1e-9 * np.abs(expected).max(axis=0))


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
    """Central differences of 1e-5, of a model with a product of two coefficients, over several blocks of states."""
    model = resolve("remus-kt")
    equations, theta = PinnEquations.of(model.blanked()), model.coefficients
    x, u, step = rng.normal(size=(250, 3)), rng.normal(size=(250, 1)), 1e-5
    with require_jax().enable_x64(True):
        rates, by_state, by_theta = equations.derivatives(x, u, theta)
        assert rates == pytest.approx(equations.rates(x, u, theta), rel=1e-12, abs=1e-12)
        for k, move in enumerate(step * np.eye(3)):
            change = (equations.rates(x + move, u, theta) - equations.rates(x - move, u, theta)) / (2.0 * step)
            assert by_state[:, :, k] == pytest.approx(change, abs=1e-8)
        for k, move in enumerate(step * np.eye(4)):
            change = (equations.rates(x, u, theta + move) - equations.rates(x, u, theta - move)) / (2.0 * step)
            assert by_theta[:, :, k] == pytest.approx(change, abs=1e-8)
