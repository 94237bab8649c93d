"""The black-box predictor integrates learnt accelerations as the model does."""

import numpy as np
import pytest

from helmbench.estimation.methods_only.black_box.scaled import Scaled
from helmbench.estimation.results.predictor import ModelPredictor
from helmbench.methods.black_box import BlackBoxPredictor, features_of
from helmbench.models.model import resolve
from helmbench.models.simulate import accelerations, initial_state


def perfect(model):
    """A predictor whose regressor knows the model's own accelerations."""
    names = features_of(model)
    k = 3 if model.is_3dof else 1

    def exact(features):
        given = dict(zip(names, features.T, strict=True))
        x = np.zeros((len(features), len(model.states)))
        gain = model.kernels.RATE_GAIN
        shift = 0.0 if gain is None else model.coefficients[gain]
        for place, name in enumerate(model.states):
            if name == "w":
                x[:, place] = given["q"] - shift * given["delta"]
            elif name in given:
                x[:, place] = given[name]
        u = np.column_stack([given[name] for name in model.inputs])
        rates = accelerations(model, x, u)[:, :k]
        return rates if gain is None else rates + shift * given["delta_rate"][:, None]

    d = len(names)
    scaling = (np.zeros(d), np.ones(d), np.zeros(k), np.ones(k))
    return BlackBoxPredictor(model.states, model.inputs, names, Scaled(*scaling, (), exact))


@pytest.mark.parametrize("ship", ["mariner", "response-1", "response-2", "kvlcc2-l7"])
def test_free_run_and_step_are_the_model_s_own(ship, rng):
    model = resolve(ship)
    dt = model.max_step_s  # the black box takes one step a sample
    delta = np.cumsum(rng.normal(0.0, 0.02, 120))
    inputs = np.column_stack([delta, *(np.full(120, model.n0_rps) for name in model.inputs if name == "n")])
    start = initial_state(model)
    start[model.states.index("r")] += 0.001
    mine, other = perfect(model), ModelPredictor(model)
    free = mine.simulate(inputs, dt, start)
    expected = other.simulate(inputs, dt, start)
    columns = [place for place, name in enumerate(model.states) if name != "w"]
    np.testing.assert_allclose(free[:, columns], expected[:, columns], rtol=1e-9, atol=1e-12)
    states = free[:-1] + rng.normal(0.0, 1e-3, free[:-1].shape)
    ahead, ahead_expected = mine.step(states, inputs, dt), other.step(states, inputs, dt)
    np.testing.assert_allclose(ahead[:, columns], ahead_expected[:, columns], rtol=1e-9, atol=1e-12)


def test_far_outside_nothing_is_predicted():
    predictor = perfect(resolve("response-1"))
    run = predictor.simulate(np.full((50, 1), 1e4), 0.1, np.zeros(2))
    assert np.isnan(run[-1]).all() and np.isfinite(run[0]).all()
