"""Linear and neural state-space models: exact on linear systems, and predictors that agree with themselves."""

import sys
import types

import numpy as np
import pytest

from helmbench.datasets.generator import Case, generate
from helmbench.estimation.methods_only.black_box.rows import Signals
from helmbench.estimation.methods_only.black_box.state_space import SignalScales, Training, pasts, training_of
from helmbench.methods.recurrent import LAGS, STEPS, WINDOWS, RecurrentNetwork, train_recurrent, windows_of
from helmbench.methods.registry import make
from helmbench.methods.subspace import identify
from helmbench.models.errors import BadInput, CannotFit, FitFailed
from helmbench.models.model import resolve

MODEL = resolve("cargo")


def linear(rng, n=300, noise=0.0):
    """Signals of a linear system of two states, one input and one output, with an offset; the matrix A."""
    a, b, c = np.array([[0.9, 0.2], [-0.1, 0.7]]), np.array([0.5, 1.0]), np.array([1.0, 0.3])
    w, x, z = rng.normal(size=n), np.zeros(2), np.zeros(n)
    for t in range(n):
        z[t] = c @ x
        x = a @ x + b * w[t] + 0.1
    z += noise * rng.normal(size=n)
    return Signals(1.0, z[:, None], w[:, None], np.ones(n, bool)), a


def training(*parts):
    one = SignalScales(np.zeros(1), np.ones(1), np.zeros(1), np.ones(1))
    return Training(MODEL, 1, 1.0, one, parts)


def free_run(system, part, lags, first, last):
    state = system.begin(pasts(part, np.array([first]), 1, lags))
    found = []
    for t in range(first, last):
        state = system.advance(state, part.inputs[t : t + 1])
        found.append(state[0, 0])
    return np.array(found)


def test_a_linear_system_is_identified_exactly(rng):
    parts = [linear(rng) for _ in range(2)]
    system, lags = identify(training(*(part for part, _ in parts)), 2)
    np.testing.assert_allclose(np.sort(np.linalg.eigvals(system.a)), np.sort(np.linalg.eigvals(parts[0][1])), rtol=1e-5)
    held_out, _ = linear(rng)
    np.testing.assert_allclose(free_run(system, held_out, lags, 20, 120), held_out.outputs[21:121, 0], atol=2e-4)


def test_gaps_carry_no_weight(rng):
    part, a = linear(rng, 500)
    broken = part.outputs.copy()
    broken[200:220] = 50.0
    whole = part.whole.copy()
    whole[200:220] = False
    system, _ = identify(training(part._replace(outputs=broken, whole=whole)), 2)
    np.testing.assert_allclose(np.sort(np.linalg.eigvals(system.a)), np.sort(np.linalg.eigvals(a)), rtol=1e-5)


def test_eigenvalues_are_kept_within_the_unit_circle():
    rng = np.random.default_rng(0)  # any growing series
    w = rng.normal(size=(150, 1))
    z = np.zeros((150, 1))
    for t in range(149):
        z[t + 1] = 1.05 * z[t] + w[t]
    system, _ = identify(training(Signals(1.0, z, w, np.ones(150, bool))), 1)
    np.testing.assert_allclose(np.abs(np.linalg.eigvals(system.a)), 1.0 / 1.05, rtol=1e-3)


def test_too_few_rows_are_refused(rng):
    part, _ = linear(rng, 30)
    with pytest.raises(CannotFit, match="usable rows for 31 unknowns"):
        identify(training(part), 4)
    with pytest.raises(CannotFit, match="usable rows"):
        windows_of(training(Signals(*(v if i == 0 else v[:6] for i, v in enumerate(part)))), LAGS, STEPS, WINDOWS)


def test_infinite_signals_fail():
    record = generate(Case("cargo", "zigzag:20/20"))
    with pytest.raises(FitFailed, match="not finite"):
        training_of([record.with_channels(yaw_rate_rad_s=1e200 * record.column("yaw_rate_rad_s"))], MODEL, 2)


def test_before_the_first_sample_everything_is_constant():
    part = Signals(1.0, np.arange(6.0)[:, None], 10.0 + np.arange(6.0)[:, None], np.ones(6, bool))
    assert pasts(part, np.array([0, 5]), 2, 2).tolist() == [[0.0, 0.0, 10.0, 10.0], [5.0, 3.0, 13.0, 11.0]]


def test_windows_end_with_their_record_and_before_gaps(rng):
    part, _ = linear(rng, 100)
    whole = part.whole.copy()
    whole[50] = False
    windows = windows_of(training(part._replace(whole=whole)), LAGS, STEPS, WINDOWS)
    assert windows.weight.shape == (STEPS, WINDOWS) and windows.outputs.shape == (STEPS, WINDOWS, 1)
    lengths = windows.weight.sum(axis=0)
    np.testing.assert_array_equal(windows.weight, np.arange(STEPS)[:, None] < lengths)
    first = np.array([np.flatnonzero(part.outputs[:, 0] == z)[0] for z in windows.past[:, 0]])
    end = np.where(first < 50, 49, 99)
    np.testing.assert_array_equal(lengths, np.minimum(end - first, STEPS))


def test_a_network_learns_a_linear_system(rng):
    part, _ = linear(rng)
    network = train_recurrent(training(part), hidden=2, units=3, alpha=1e-9, seed=0)
    held_out, _ = linear(rng)
    error = free_run(network, held_out, 3, 20, 120) - held_out.outputs[21:121, 0]
    assert np.sqrt(np.mean(error**2)) < 0.1 * held_out.outputs.std()
    assert all(isinstance(array, np.ndarray) for array in network) and isinstance(network, RecurrentNetwork)


def test_with_a_jax_that_is_too_old_it_does_not_apply_either(monkeypatch):
    old = types.ModuleType("jax")
    old.__version__ = "0.7.2"
    monkeypatch.setitem(sys.modules, "jax", old)
    with pytest.raises(CannotFit, match=r"needs jax 0.8 or newer, not 0.7.2: pip install 'helmbench\[deep\]'"):
        make("recurrent").fit(generate(Case("cargo", "zigzag:20/20")), MODEL)


def test_without_jax_the_recurrent_network_does_not_apply(monkeypatch):
    monkeypatch.setitem(sys.modules, "jax", None)
    with pytest.raises(CannotFit, match=r"needs jax: pip install 'helmbench\[deep\]'"):
        make("recurrent").fit(generate(Case("cargo", "zigzag:20/20")), MODEL)


@pytest.mark.parametrize("option", ["units=0", "hidden=-1"])
def test_impossible_networks_are_refused(option):
    with pytest.raises(BadInput, match="a whole number of at least"):
        make(f"recurrent,{option}").check_options()
