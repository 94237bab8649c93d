"""Free runs of windows of records, and their mean square error with gradients from jax: what networks are trained on.

Signals, pasts and systems are those of `state_space`.  A window begins from the samples before it and is run freely
from there; what it is compared with are the outputs of each of its steps.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from ....models.errors import CannotFit
from ....models.extras import extras_told
from .scaled import evenly_spaced
from .state_space import Training, pasts

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
