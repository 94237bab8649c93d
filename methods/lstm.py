"""A long short-term memory network, trained on free runs of windows by gradients from jax.

With the scaled signals of `black_box.state_space`, a hidden state m and a cell state c of as many entries as there are
units,

    i, f, o = sigma(W (z(t), w(t), m(t), 1)),    g = tanh(W' (z(t), w(t), m(t), 1))
    c(t + h) = f c(t) + i g,    m(t + h) = o tanh(c(t + h)),    z(t + h) = z(t) + V (m(t + h), 1)

(Hochreiter & Schmidhuber 1997, Neural Comput. 9(8), 1735, with the forget gate f of Gers, Schmidhuber & Cummins 2000,
Neural Comput. 12(10), 2451).  A run begins with m = c = 0 at the oldest sample of its past and takes the measured
outputs up to its own first sample; from there on, its own.

Training is Adam (Kingma & Ba 2015, arXiv 1412.6980, algorithm 1) with decoupled decay of the weights (Loshchilov &
Hutter 2019, arXiv 1711.05101, algorithm 2), a step size that falls as half a cosine, and gradients cut to a length of 1
(Pascanu, Mikolov & Bengio 2013, arXiv 1211.5063, algorithm 1), on mini batches of windows that are run freely.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import cache
from typing import Any, NamedTuple

import numpy as np

from ..datasets.record import Record
from ..estimation.methods_only.black_box.free_runs import (
    FreeRunWindows,
    beside,
    mean_square,
    require_jax,
    tanh,
    windows_of,
)
from ..estimation.methods_only.black_box.state_space import Training, training_of
from ..estimation.methods_only.tuning.space import Integer, Real
from ..estimation.results.fit import Fit
from ..models.errors import FitFailed
from ..models.model import Model
from .base import method
from .learner import in_order
from .options import NOT_NEGATIVE, option, whole


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
    network = train(training, units, iterations, decay, seed)
    return training.fit(network, LAGS)._replace(n_iterations=iterations)


LAGS = 5
"""Steps of a past."""
STEPS, BATCH = 60, 32
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
        """States (N, k + 2 units) after pasts (N, LAGS (k + nu))."""
        k, units = self.out.shape[1], len(self.out) - 1
        z, w = past[:, : LAGS * k], past[:, LAGS * k :]
        nu = w.shape[1] // LAGS
        memory = z[:, :1] * np.zeros(2 * units, z.dtype)
        for lag in range(LAGS - 1, 0, -1):
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


def train(training: Training, units: int, iterations: int, decay: float, seed: int) -> LstmNetwork:
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
    windows = FreeRunWindows(*(part.astype(np.float32) for part in windows_of(training, LAGS, STEPS)))
    network = _first(windows, units, rng)
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


def _first(windows: FreeRunWindows, units: int, rng: np.random.Generator) -> LstmNetwork:
    """Where training starts: random gates that remember, and small increments."""
    k, nu = windows.outputs.shape[2], windows.inputs.shape[2]
    gates = rng.normal(size=(k + nu + units + 1, 4 * units)) / np.sqrt(k + nu + units)
    gates[-1] = np.repeat([0.0, 1.0, 0.0, 0.0], units)
    out = 0.01 * rng.normal(size=(units + 1, k))
    return LstmNetwork(gates.astype(np.float32), out.astype(np.float32))
