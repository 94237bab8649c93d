"""Recurrent networks, trained on free runs of windows of records by gradients from jax.

Signals, pasts and systems are the scaled ones of `black_box.state_space`.  A window begins from the samples before it
and is run freely from there; what it is compared with are the outputs of each of its steps.

Of `recurrent`, hidden states at the start of a run are E (p, 1), p the past.  The mean square of errors over windows
plus a penalty on A, U, V and E is minimised by L-BFGS.

Of `lstm`, with a hidden state m and a cell state c of as many entries as there are units,

    i, f, o = sigma(W (z(t), w(t), m(t), 1)),    g = tanh(W' (z(t), w(t), m(t), 1))
    c(t + h) = f c(t) + i g,    m(t + h) = o tanh(c(t + h)),    z(t + h) = z(t) + V (m(t + h), 1)

(Hochreiter & Schmidhuber 1997, Neural Comput. 9(8), 1735, with the forget gate f of Gers, Schmidhuber & Cummins 2000,
Neural Comput. 12(10), 2451).  A run begins with m = c = 0 at the oldest sample of its past and takes the measured
outputs up to its own first sample; from there on, its own.

Its training is Adam (Kingma & Ba 2015, arXiv 1412.6980, algorithm 1) with decoupled decay of the weights (Loshchilov &
Hutter 2019, arXiv 1711.05101, algorithm 2), a step size that falls as half a cosine, and gradients cut to a length of 1
(Pascanu, Mikolov & Bengio 2013, arXiv 1211.5063, algorithm 1), on mini batches of windows that are run freely.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import cache
from typing import Any, NamedTuple

import numpy as np

from ..datasets.record import Record
from ..estimation.methods_only.black_box.scaled import evenly_spaced
from ..estimation.methods_only.black_box.state_space import Training, pasts, training_of
from ..estimation.methods_only.tuning.space import Integer, Real
from ..estimation.results.fit import Fit
from ..models.errors import CannotFit, FitFailed
from ..models.extras import extras_told
from ..models.linear_algebra import ridge
from ..models.model import Model
from .base import method
from .learner import STRIDE, Learner, in_order, open_option
from .options import NOT_NEGATIVE, option, whole

LARGEST_STATE = 30.0
"""Standard deviations at which states are cut while training: a start that diverges has finite gradients."""


class FreeRunWindows(NamedTuple):
    """Pasts (B, q); inputs (T, B, nu) and outputs (T, B, k) of each step and the one after it; weights (T, B)."""

    past: np.ndarray
    inputs: np.ndarray
    outputs: np.ndarray
    weight: np.ndarray


def require_jax() -> Any:
    """The module jax; CannotFit where it is not installed, or too old: `jax.enable_x64` came with 0.8."""
    with extras_told(CannotFit):
        import jax
    if not hasattr(jax, "enable_x64"):
        raise CannotFit(f"this needs jax 0.8 or newer, not {jax.__version__}: pip install 'helmbench[deep]'")
    return jax


def beside(first: Any, second: Any) -> Any:
    """Columns of numpy or jax arrays."""
    return np.hstack([first, second]) if isinstance(first, np.ndarray) else require_jax().numpy.hstack([first, second])


def tanh(x: Any) -> Any:
    """Of a numpy or jax array."""
    return np.tanh(x) if isinstance(x, np.ndarray) else require_jax().numpy.tanh(x)


def windows_of(training: Training, lags: int, steps: int, count: int | None = None) -> FreeRunWindows:
    """Windows of `steps` steps at most, begun from pasts of `lags` steps.

    Parameters
    ----------
    count : windows at samples evenly spaced over all records, exactly as many; None: one at every sample.

    Raises
    ------
    CannotFit : there are too few samples.
    """
    s, found = training.stride, []
    for part in training.parts:
        n = len(part.whole)
        place = np.arange(n - s)
        ahead = place[:, None] + s * np.arange(steps + 1)
        inside = ahead < n
        ahead = np.minimum(ahead, n - 1)
        weight = np.logical_and.accumulate(part.whole[ahead] & inside, axis=1)[:, 1:]
        kept = weight.any(axis=1)
        inputs, outputs = part.inputs[ahead[kept, :-1]], part.outputs[ahead[kept, 1:]]
        found.append((pasts(part, place[kept], s, lags), inputs, outputs, weight[kept].astype(float)))
    n, d = sum(len(past) for past, *_ in found), found[0][0].shape[1]
    if n <= d:
        raise CannotFit(f"{n} usable rows for {d} features")
    chosen = np.arange(n) if count is None else np.resize(evenly_spaced(n, count), count)
    past, inputs, outputs, weight = (np.concatenate(blocks)[chosen] for blocks in zip(*found, strict=True))
    return FreeRunWindows(past, inputs.swapaxes(0, 1), outputs.swapaxes(0, 1), weight.T)


def mean_square(system: Any, windows: FreeRunWindows) -> Any:
    """Mean square error of a system's free runs over windows, as a jax scalar.

    Parameters
    ----------
    system : a `state_space.System` of jax arrays.
    """
    jax = require_jax()

    def step(state: Any, now: tuple) -> tuple:
        inputs, wanted, weight = now
        ahead = jax.numpy.clip(system.advance(state, inputs), -LARGEST_STATE, LARGEST_STATE)
        return ahead, (weight * ((ahead[:, : wanted.shape[1]] - wanted) ** 2).sum(axis=1)).sum()

    _, squares = jax.lax.scan(step, system.begin(windows.past), windows[1:])
    return squares.sum() / (windows.weight.sum() * windows.outputs.shape[2])


# ---- A small network with hidden states.


@method("recurrent", "recurrent neural network (neural state space), trained on free runs", Learner, usual_trials=4)
def Recurrent(
    records: Sequence[Record],
    model: Model,
    seed: int,
    stride: int | None = STRIDE,
    alpha: float | None = open_option("penalty on the weights", Real(1e-7, 1e-3, log=True), 1e-5),
    units: int = option(8, "tanh units", whole(1)),
    hidden: int = option(2, "hidden states", whole(0)),
) -> Fit:
    """Recurrent network: a neural state-space model with hidden states, trained on free runs of windows.

        s(t + h) = s(t) + A (s, w, 1) + V tanh(U (s, w, 1)),    s = (z, hidden states)

    Hidden states begin as a linear function of past samples.  Gradients through the recursion are jax's, so the method
    needs the extra `deep` and does not apply without it.  Sources: Suykens, De Moor & Vandewalle 1995, Int. J. Control
    62(1), 129; Beintema, Toth & Schoukens 2021, PMLR 144, 1021.
    """
    training = training_of(records, model, int(stride or 1))
    return training.fit(train_recurrent(training, hidden, units, alpha or 0.0, seed), LAGS)


LAGS = 3
"""Steps of a past."""
STEPS, WINDOWS = 40, 64
"""Most steps of a window, and number of windows: fixed, so that jax compiles once for a model's signals."""
ITERATIONS = 80


class RecurrentNetwork(NamedTuple):
    """A system as `state_space.System`: k outputs, m hidden states, nu inputs, n = k + m, pasts of q entries.

    Parameters
    ----------
    a : (n + nu + 1, n); u : (n + nu + 1, units); v : (units, n); e : (q + 1, m).
    """

    a: Any
    u: Any
    v: Any
    e: Any

    def begin(self, past: Any) -> Any:
        """States (N, n) after pasts (N, q)."""
        outputs = self.a.shape[1] - self.e.shape[1]
        return beside(past[:, :outputs], past @ self.e[:-1] + self.e[-1])

    def advance(self, state: Any, inputs: Any) -> Any:
        """States (N, n) one step on under inputs (N, nu)."""
        x = beside(state, inputs)
        return state + x @ self.a[:-1] + self.a[-1] + tanh(x @ self.u[:-1] + self.u[-1]) @ self.v


def train_recurrent(training: Training, hidden: int, units: int, alpha: float, seed: int) -> RecurrentNetwork:
    """The network of `hidden` states and `units` tanh units with the penalty alpha on its weights.

    Raises
    ------
    CannotFit : jax is not installed or too old, or there are too few samples.
    FitFailed : no finite network is found.
    """
    from scipy.optimize import minimize

    jax = require_jax()
    windows = windows_of(training, LAGS, STEPS, WINDOWS)
    start = _first_recurrent(windows, hidden, units, np.random.default_rng(seed))
    sizes = np.cumsum([part.size for part in start])[:-1]

    def network(flat: np.ndarray) -> RecurrentNetwork:
        return RecurrentNetwork(*(p.reshape(q.shape) for p, q in zip(np.split(flat, sizes), start, strict=True)))

    with jax.enable_x64(True), jax.default_device(jax.local_devices(backend="cpu")[0]):

        def loss(flat: np.ndarray) -> tuple[float, np.ndarray]:
            value, slope = _loss_and_slope()(network(flat), windows, alpha)
            return float(value), np.concatenate([np.ravel(part) for part in slope])

        flat = np.concatenate([part.ravel() for part in start])
        found = minimize(loss, flat, jac=True, method="L-BFGS-B", options={"maxiter": ITERATIONS})
    if not (np.isfinite(found.fun) and np.isfinite(found.x).all()):
        raise FitFailed("training gives no finite network")
    return network(found.x)


@cache
def _loss_and_slope() -> Callable[..., Any]:
    """Loss and its derivatives by the network's arrays, compiled for each set of shapes."""
    jax = require_jax()

    def loss(network: RecurrentNetwork, windows: FreeRunWindows, alpha: float) -> Any:
        return mean_square(network, windows) + alpha * sum((part**2).sum() for part in network)

    return jax.jit(jax.value_and_grad(loss))


def _first_recurrent(windows: FreeRunWindows, hidden: int, units: int, rng: np.random.Generator) -> RecurrentNetwork:
    """Where training starts: the linear part by least squares one step ahead, the rest small and random."""
    k, nu, q = windows.outputs.shape[2], windows.inputs.shape[2], windows.past.shape[1]
    n = k + hidden
    known = windows.weight[0] > 0.0
    now = np.hstack([windows.past[:, :k], windows.inputs[0], np.ones((len(known), 1))])[known]
    rates = windows.outputs[0][known] - now[:, :k]
    linear = ridge(now, rates, 1e-3 * np.sqrt(len(now)))
    a = 0.01 * rng.normal(size=(n + nu + 1, n))
    a[np.ix_([*range(k), *range(n, n + nu + 1)], range(k))] = linear
    a[k:n, k:] -= 0.5 * np.eye(hidden)
    u, v, e = rng.normal(size=(n + nu + 1, units)), rng.normal(size=(units, n)), rng.normal(size=(q + 1, hidden))
    return RecurrentNetwork(a, u / np.sqrt(len(u)), 0.01 * v, e / np.sqrt(len(e)))


# ---- A long short-term memory network.


@method(
    "lstm",
    "long short-term memory network (LSTM), trained on free runs",
    kind="black box",
    minutes=True,
    brief={"units": 8, "iterations": 100},
)
def Lstm(
    records: Sequence[Record],
    model: Model,
    stride: int = option(2, "h in samples", whole(1), Integer(1, 8, log=True)),
    decay: float = option(
        0.4, "of the weights at each update, relative to the step size", NOT_NEGATIVE, Real(0.1, 1.0, log=True)
    ),
    units: int = option(32, "hidden states, and as many cell states", whole(1)),
    iterations: int = option(2000, "updates of the weights", whole(1)),
    seed: int = option(0, "of the first weights and the batches", whole(0)),
) -> Fit:
    """Long short-term memory network of outputs and inputs, trained on free runs of windows.

        z(t + h) = z(t) + V (m, 1),    m: hidden state of an LSTM layer that takes z and w of every step

    A run begins with a memory of zeros some steps before its first sample and takes the measured outputs up to there.
    Training is Adam on mini batches with a decay of the weights, for a fixed number of updates.  There is neither early
    stopping nor a choice of options within the fit: on five simulated ships, both judged by the later part of the same
    training records, neither predicted other manoeuvres better, and the choice twice much worse.  Gradients through the
    recursion are jax's, so the method needs the extra `deep` and does not apply without it.  Sources: Hochreiter &
    Schmidhuber 1997, Neural Comput. 9(8), 1735; for ships Woo, Park, Yu & Kim 2018, Appl. Ocean Res. 73.
    """
    training = training_of(in_order(records), model, stride)
    network = train_lstm(training, units, iterations, decay, seed)
    return training.fit(network, LSTM_LAGS)._replace(n_iterations=iterations)


LSTM_LAGS = 5
"""Steps of a past."""
LSTM_STEPS, BATCH = 60, 32
"""Most steps of a window, and windows of a batch."""
TOGETHER = 50
"""Updates of one call of compiled code."""
STEP_SIZE, LAST_SHARE = 1e-2, 1e-3
"""Step size of the first update, and of the last one relative to it."""
MEMORY, MEMORY_OF_SQUARES = 0.9, 0.999
"""Of the averages of gradients and of their squares."""
TINY = 1e-8
"""Added to the root of the mean square of a gradient."""


class LstmNetwork(NamedTuple):
    """A system as `state_space.System`: k outputs, nu inputs, state (z, m, c) of k + 2 units entries.

    Parameters
    ----------
    gates : (k + nu + units + 1, 4 units), of the input, forget and output gates and of what is written.
    out : (units + 1, k).
    """

    gates: Any
    out: Any

    def begin(self, past: Any) -> Any:
        """States (N, k + 2 units) after pasts (N, LSTM_LAGS (k + nu))."""
        k, units = self.out.shape[1], len(self.out) - 1
        z, w = past[:, : LSTM_LAGS * k], past[:, LSTM_LAGS * k :]
        nu = w.shape[1] // LSTM_LAGS
        memory = z[:, :1] * np.zeros(2 * units, z.dtype)
        for lag in range(LSTM_LAGS - 1, 0, -1):
            now = beside(z[:, lag * k : (lag + 1) * k], w[:, (lag - 1) * nu : lag * nu])
            memory = self._remember(now, memory)
        return beside(z[:, :k], memory)

    def advance(self, state: Any, inputs: Any) -> Any:
        """States (N, k + 2 units) one step on under inputs (N, nu)."""
        k, units = self.out.shape[1], len(self.out) - 1
        z = state[:, :k]
        memory = self._remember(beside(z, inputs), state[:, k:])
        return beside(z + memory[:, :units] @ self.out[:-1] + self.out[-1], memory)

    def _remember(self, now: Any, memory: Any) -> Any:
        """(m, c) of shape (N, 2 units) one step after `memory`, with outputs and inputs `now` (N, k + nu)."""
        units = len(self.out) - 1
        x = beside(now, memory[:, :units]) @ self.gates[:-1] + self.gates[-1]
        gate = 0.5 + 0.5 * tanh(0.5 * x[:, : 3 * units])
        cell = gate[:, units : 2 * units] * memory[:, units:] + gate[:, :units] * tanh(x[:, 3 * units :])
        return beside(gate[:, 2 * units :] * tanh(cell), cell)


def train_lstm(training: Training, units: int, iterations: int, decay: float, seed: int) -> LstmNetwork:
    """The network of that many units after `iterations` updates.

    Parameters
    ----------
    decay : of the weights at each update, relative to the step size.

    Raises
    ------
    CannotFit : jax is not installed or too old, or there are too few samples.
    FitFailed : no finite network is found.
    """
    jax, rng = require_jax(), np.random.default_rng(seed)
    windows = FreeRunWindows(*(part.astype(np.float32) for part in windows_of(training, LSTM_LAGS, LSTM_STEPS)))
    network = _first_lstm(windows, units, rng)
    still = LstmNetwork(*(np.zeros_like(part) for part in network))
    state = network, still, still, np.float32(0.0)
    with jax.enable_x64(False), jax.default_device(jax.local_devices(backend="cpu")[0]):
        for sizes in np.split(_step_sizes(iterations), range(TOGETHER, iterations, TOGETHER)):
            batches = _batches(windows, rng.integers(len(windows.past), size=(len(sizes), BATCH)))
            state = _updates()(state, batches, sizes, np.float32(decay))
    network = LstmNetwork(*(np.asarray(part, float) for part in state[0]))
    if not all(np.isfinite(part).all() for part in network):
        raise FitFailed("training gives no finite network")
    return network


def _step_sizes(iterations: int) -> np.ndarray:
    """Of each update (iterations,): half a cosine from the first to the last."""
    fallen = 0.5 + 0.5 * np.cos(np.pi * np.arange(iterations) / iterations)
    return (STEP_SIZE * (LAST_SHARE + (1.0 - LAST_SHARE) * fallen)).astype(np.float32)


def _batches(windows: FreeRunWindows, chosen: np.ndarray) -> FreeRunWindows:
    """FreeRunWindows chosen (U, B) for U updates, with a first axis of U entries."""
    over_time = (np.moveaxis(part[:, chosen], 1, 0) for part in windows[1:])
    return FreeRunWindows(windows.past[chosen], *over_time)


@cache
def _updates() -> Callable[..., Any]:
    """(network, mean gradient, mean square, count) after an update by each batch, compiled for each set of shapes."""
    jax = require_jax()
    each, root = jax.tree.map, jax.numpy.sqrt

    def update(state: tuple, batch: FreeRunWindows, size: Any, decay: Any) -> tuple:
        network, mean, square, count = state
        slope = jax.grad(mean_square)(network, batch)
        cut = jax.numpy.maximum(1.0, root(sum((g**2).sum() for g in slope)))
        mean = each(lambda m, g: MEMORY * m + (1.0 - MEMORY) * g / cut, mean, slope)
        square = each(lambda s, g: MEMORY_OF_SQUARES * s + (1.0 - MEMORY_OF_SQUARES) * (g / cut) ** 2, square, slope)
        count += 1.0
        known, known_squares = 1.0 - MEMORY**count, 1.0 - MEMORY_OF_SQUARES**count

        def moved(p: Any, m: Any, s: Any) -> Any:
            return p - size * (m / known / (root(s / known_squares) + TINY) + decay * p)

        return each(moved, network, mean, square), mean, square, count

    def updates(state: tuple, batches: FreeRunWindows, sizes: Any, decay: Any) -> tuple:
        def one(now: tuple, given: tuple[FreeRunWindows, Any]) -> tuple[tuple, None]:
            return update(now, *given, decay), None

        return jax.lax.scan(one, state, (batches, sizes))[0]

    return jax.jit(updates)


def _first_lstm(windows: FreeRunWindows, units: int, rng: np.random.Generator) -> LstmNetwork:
    """Where training starts: random gates that remember, and small increments."""
    k, nu = windows.outputs.shape[2], windows.inputs.shape[2]
    gates = rng.normal(size=(k + nu + units + 1, 4 * units)) / np.sqrt(k + nu + units)
    gates[-1] = np.repeat([0.0, 1.0, 0.0, 0.0], units)
    out = 0.01 * rng.normal(size=(units + 1, k))
    return LstmNetwork(gates.astype(np.float32), out.astype(np.float32))
