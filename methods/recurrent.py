"""A small recurrent network: a neural state-space model, trained on free runs of windows by gradients from jax.

Signals are the scaled ones of `black_box.state_space`; hidden states at the start of a run are E (p, 1), p the past.
The mean square of errors over windows of `STEPS` steps, each begun from the samples before it, plus a penalty on A, U,
V and E, is minimised by L-BFGS.
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
from ..estimation.methods_only.tuning.space import Real
from ..estimation.results.fit import Fit
from ..models.errors import FitFailed
from ..models.linear_algebra import ridge
from ..models.model import Model
from .base import method
from .learner import STRIDE, Learner, open_option
from .options import option, whole


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
    return training.fit(train(training, hidden, units, alpha or 0.0, seed), LAGS)


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


def train(training: Training, hidden: int, units: int, alpha: float, seed: int) -> RecurrentNetwork:
    """The network of `hidden` states and `units` tanh units with the penalty alpha on its weights.

    Raises
    ------
    CannotFit : jax is not installed or too old, or there are too few samples.
    FitFailed : no finite network is found.
    """
    from scipy.optimize import minimize

    jax = require_jax()
    windows = windows_of(training, LAGS, STEPS, WINDOWS)
    start = _first(windows, hidden, units, np.random.default_rng(seed))
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


def _first(windows: FreeRunWindows, hidden: int, units: int, rng: np.random.Generator) -> RecurrentNetwork:
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
