"""The long short-term memory network: its step, its past, its training, and what it refuses."""

import sys

import numpy as np
import pytest
from scipy.special import expit

from helmbench.datasets.generator import Case, generate
from helmbench.estimation.methods_only.black_box.rows import Signals
from helmbench.estimation.methods_only.black_box.state_space import pasts
from helmbench.estimation.run.prediction import prediction_scores
from helmbench.methods import contract
from helmbench.methods.recurrent import (
    LSTM_LAGS,
    LSTM_STEPS,
    STEP_SIZE,
    LstmNetwork,
    mean_square,
    require_jax,
    train_lstm,
    windows_of,
)
from helmbench.methods.registry import make
from helmbench.models.errors import BadInput, CannotFit
from helmbench.models.model import resolve

from .test_state_space import free_run, linear, training

K, NU, UNITS = 2, 3, 4


def network(rng):
    return LstmNetwork(rng.normal(size=(K + NU + UNITS + 1, 4 * UNITS)), rng.normal(size=(UNITS + 1, K)))


def cell(net, z, w, hidden, cell_state):
    """One step of the layer for one row, gate by gate, as in the sources."""
    i, f, o, g = np.split(np.concatenate([z, w, hidden, [1.0]]) @ net.gates, 4)
    cell_state = expit(f) * cell_state + expit(i) * np.tanh(g)
    return expit(o) * np.tanh(cell_state), cell_state


def test_a_step_is_that_of_the_literature(rng):
    net, (z, w, hidden, cell_state) = network(rng), map(rng.normal, [0.0] * 4, [1.0] * 4, [K, NU, UNITS, UNITS])
    ahead = net.advance(np.concatenate([z, hidden, cell_state])[None], w[None])[0]
    hidden, cell_state = cell(net, z, w, hidden, cell_state)
    expected = np.concatenate([z + np.append(hidden, 1.0) @ net.out, hidden, cell_state])
    np.testing.assert_allclose(ahead, expected, rtol=1e-12, atol=1e-12)


def test_a_run_begins_with_the_memory_of_its_past(rng):
    net, n = network(rng), 20
    part = Signals(1.0, rng.normal(size=(n, K)), rng.normal(size=(n, NU)), np.ones(n, bool))
    state = net.begin(pasts(part, np.array([11]), 2, LSTM_LAGS))[0]
    hidden, cell_state = np.zeros(UNITS), np.zeros(UNITS)
    for sample in (3, 5, 7, 9):
        hidden, cell_state = cell(net, part.outputs[sample], part.inputs[sample], hidden, cell_state)
    expected = np.concatenate([part.outputs[11], hidden, cell_state])
    np.testing.assert_allclose(state, expected, rtol=1e-12, atol=1e-12)


@pytest.mark.nightly
def test_the_loss_is_the_error_of_free_runs(rng):
    part, _ = linear(rng, 100)
    windows = windows_of(training(part), LSTM_LAGS, LSTM_STEPS)
    net = LstmNetwork(rng.normal(size=(1 + 1 + UNITS + 1, 4 * UNITS)), 0.1 * rng.normal(size=(UNITS + 1, 1)))
    state, total = net.begin(windows.past), 0.0
    for inputs, outputs, weight in zip(*windows[1:], strict=True):
        state = net.advance(state, inputs)
        total += weight @ (state[:, :1] - outputs)[:, 0] ** 2
    jax = require_jax()
    with jax.enable_x64(True):
        arrays = jax.tree.map(jax.numpy.asarray, (net, windows))
        assert float(mean_square(*arrays)) == pytest.approx(total / windows.weight.sum(), rel=1e-9)


@pytest.mark.nightly
def test_the_first_update_moves_every_weight_by_the_step_size_and_the_decay(rng):
    """Adam's first update is the sign of the gradient, whatever its size; the step size is single precision."""
    part, _ = linear(rng, 100)
    free, held = (train_lstm(training(part), UNITS, 1, decay, seed=0) for decay in (0.0, 0.5))
    first = train_lstm(training(part), UNITS, 0, 0.0, seed=0)
    for before, after, decayed in zip(first, free, held, strict=True):
        moved = np.abs(after - before)
        assert np.median(moved) == pytest.approx(STEP_SIZE, rel=1e-3) and moved.max() < 1.001 * STEP_SIZE
        np.testing.assert_allclose(decayed, after - 0.5 * STEP_SIZE * before, atol=1e-6)


@pytest.mark.nightly
def test_a_network_learns_a_linear_system(rng):
    part, _ = linear(rng, 400)
    net = train_lstm(training(part), units=16, iterations=800, decay=0.02, seed=0)
    held_out, _ = linear(rng)
    error = free_run(net, held_out, LSTM_LAGS, 20, 120) - held_out.outputs[21:121, 0]
    assert np.sqrt(np.mean(error**2)) < 0.3 * held_out.outputs.std()
    assert all(isinstance(array, np.ndarray) and array.dtype == float for array in net)


@pytest.mark.nightly
def test_the_seed_decides(rng):
    part, _ = linear(rng, 100)
    one, again, other = (train_lstm(training(part), UNITS, 5, 0.1, seed) for seed in (3, 3, 4))
    assert all(map(np.array_equal, one, again)) and not np.allclose(one.gates, other.gates)


@pytest.mark.nightly
def test_even_a_brief_training_beats_the_floors():
    model, records = contract.sample("kvlcc2-l7")
    fits = [make(text).fit(records, model) for text in ("lstm,units=8,iterations=100", "mean", "straight-line")]
    errors = [prediction_scores(model, records, fit.predictor)["rmse_free_yaw_rate_rad_s"] for fit in fits]
    assert errors[0] < min(errors[1:])


def test_impossible_options_are_refused():
    for text in ("lstm,units=0", "lstm,iterations=0", "lstm,stride=0", "lstm,decay=-1", "lstm,seed=-1"):
        with pytest.raises(BadInput, match="is needed"):
            make(text)


def test_without_jax_it_does_not_apply(monkeypatch):
    monkeypatch.setitem(sys.modules, "jax", None)
    with pytest.raises(CannotFit, match=r"needs jax: pip install 'helmbench\[deep\]'"):
        make("lstm").fit(generate(Case("cargo", "zigzag:20/20")), resolve("cargo"))
