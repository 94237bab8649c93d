"""A small recurrent network: a neural state-space model, trained on free runs of windows by gradients from jax.

With the scaled signals of `state_space` and the state s = (z, hidden states),

    s(t + h) = s(t) + A (s, w, 1) + V tanh(U (s, w, 1)),    hidden states at the start of a run: E (p, 1)

The mean square of errors over windows of `STEPS` steps, each begun from the samples before it, plus a penalty on A, U,
V and E, is minimised by L-BFGS.  Sources: Suykens, De Moor & Vandewalle 1995, Int. J. Control 62(1), 129 (neural state
space); Beintema, Toth & Schoukens 2021, PMLR 144, 1021 (windows begun by an encoder of past samples).
"""

from __future__ import annotations

from collections.abc import Callable
from functools import cache
from typing import Any, NamedTuple

import numpy as np
from scipy.optimize import minimize

from ...models.errors import CannotFit, FitFailed
from ...models.extras import extras_told
from ...models.linear_algebra import lstsq
from .predictor import evenly_spaced
from .state_space import Training, pasts

LAGS = 3
"""Steps of a past."""
STEPS, WINDOWS = 40, 64
"""Most steps of a window, and number of windows: fixed, so that jax compiles once for a model's signals."""
ITERATIONS = 80
LARGEST_STATE = 30.0
"""Standard deviations at which states are cut while training: a start that diverges has finite gradients."""


class Network(NamedTuple):
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
        return _beside(past[:, :outputs], past @ self.e[:-1] + self.e[-1])

    def advance(self, state: Any, inputs: Any) -> Any:
        """States (N, n) one step on under inputs (N, nu)."""
        x = _beside(state, inputs)
        return state + x @ self.a[:-1] + self.a[-1] + _tanh(x @ self.u[:-1] + self.u[-1]) @ self.v


def _beside(first: Any, second: Any) -> Any:
    """Columns of numpy or jax arrays."""
    return np.hstack([first, second]) if isinstance(first, np.ndarray) else require_jax().numpy.hstack([first, second])


def _tanh(x: Any) -> Any:
    return np.tanh(x) if isinstance(x, np.ndarray) else require_jax().numpy.tanh(x)


class Windows(NamedTuple):
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


def train(training: Training, hidden: int, units: int, alpha: float, seed: int) -> Network:
    """The network of `hidden` states and `units` tanh units with the penalty alpha on its weights.

    Raises
    ------
    CannotFit : jax is not installed or too old, or there are too few samples.
    FitFailed : no finite network is found.
    """
    jax = require_jax()
    windows = windows_of(training)
    start = _first(windows, hidden, units, np.random.default_rng(seed))
    sizes = np.cumsum([part.size for part in start])[:-1]

    def network(flat: np.ndarray) -> Network:
        return Network(*(p.reshape(q.shape) for p, q in zip(np.split(flat, sizes), start, strict=True)))

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

    def loss(network: Network, windows: Windows, alpha: float) -> Any:
        def step(state: Any, now: tuple) -> tuple:
            inputs, wanted, weight = now
            ahead = jax.numpy.clip(network.advance(state, inputs), -LARGEST_STATE, LARGEST_STATE)
            return ahead, (weight * ((ahead[:, : wanted.shape[1]] - wanted) ** 2).sum(axis=1)).sum()

        _, squares = jax.lax.scan(step, network.begin(windows.past), windows[1:])
        penalty = sum((part**2).sum() for part in network)
        return squares.sum() / (windows.weight.sum() * windows.outputs.shape[2]) + alpha * penalty

    return jax.jit(jax.value_and_grad(loss))


def windows_of(training: Training) -> Windows:
    """Windows that begin at samples evenly spaced over all records.

    Raises
    ------
    CannotFit : there are too few samples.
    """
    s, found = training.stride, []
    for part in training.parts:
        n = len(part.whole)
        place = np.arange(n - s)
        ahead = place[:, None] + s * np.arange(STEPS + 1)
        inside = ahead < n
        ahead = np.minimum(ahead, n - 1)
        weight = np.logical_and.accumulate(part.whole[ahead] & inside, axis=1)[:, 1:]
        kept = weight.any(axis=1)
        inputs, outputs = part.inputs[ahead[kept, :-1]], part.outputs[ahead[kept, 1:]]
        found.append((pasts(part, place[kept], s, LAGS), inputs, outputs, weight[kept].astype(float)))
    n, d = sum(len(past) for past, *_ in found), found[0][0].shape[1]
    if n <= d:
        raise CannotFit(f"{n} usable rows for {d} features")
    chosen = np.resize(evenly_spaced(n, WINDOWS), WINDOWS)
    past, inputs, outputs, weight = (np.concatenate(blocks)[chosen] for blocks in zip(*found, strict=True))
    return Windows(past, inputs.swapaxes(0, 1), outputs.swapaxes(0, 1), weight.T)


def _first(windows: Windows, hidden: int, units: int, rng: np.random.Generator) -> Network:
    """Where training starts: the linear part by least squares one step ahead, the rest small and random."""
    k, nu, q = windows.outputs.shape[2], windows.inputs.shape[2], windows.past.shape[1]
    n = k + hidden
    known = windows.weight[0] > 0.0
    now = np.hstack([windows.past[:, :k], windows.inputs[0], np.ones((len(known), 1))])[known]
    rates = windows.outputs[0][known] - now[:, :k]
    penalty = 1e-3 * np.sqrt(len(now)) * np.eye(now.shape[1])
    padded = np.vstack([rates, np.zeros((now.shape[1], k))])
    linear = lstsq(np.vstack([now, penalty]), padded)
    a = 0.01 * rng.normal(size=(n + nu + 1, n))
    a[np.ix_([*range(k), *range(n, n + nu + 1)], range(k))] = linear
    a[k:n, k:] -= 0.5 * np.eye(hidden)
    u, v, e = rng.normal(size=(n + nu + 1, units)), rng.normal(size=(units, n)), rng.normal(size=(q + 1, hidden))
    return Network(a, u / np.sqrt(len(u)), 0.01 * v, e / np.sqrt(len(e)))
