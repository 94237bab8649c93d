"""State-variable filter: derivatives of a sampled signal, all with the same lag.

Every signal of a linear differential equation passes through the same F(s) = omega^n/(s + omega)^n.  The equation then
holds for the filtered signals as it does for the signals themselves, at every omega; s^k F gives the derivatives (Young
1981, state-variable filters).  The derivatives of an observer, in contrast, lag by different times.
"""

from __future__ import annotations

from functools import lru_cache
from math import comb

import numpy as np
from numpy.typing import NDArray

from .linear import Discrete, discretised, respond


def filter_matrices(order: int) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """a (n, n) and b (n, 1) of 1/(s + 1)^n; state k is the k-th derivative of the output (time in units of 1/omega)."""
    a = np.eye(order, k=1)
    a[-1] = [-comb(order, k) for k in range(order)]
    b = np.zeros((order, 1))
    b[-1] = 1.0
    return a, b


@lru_cache(maxsize=64)
def sampled_filter(omega_dt: float, order: int) -> Discrete:
    """The filter's states over one sample, the signal linear between samples (first-order hold); not to be changed."""
    return discretised(*filter_matrices(order), omega_dt, "linear")


def derivatives(
    signal: NDArray[np.float64], dt: float, omega: float, order: int = 4, highest: int | None = None
) -> NDArray[np.float64]:
    """s^k F(s) signal for k = 0 .. highest, as columns (N, highest + 1), in units of the signal per second^k.

    Parameters
    ----------
    signal : (N,) without gaps.  Before the record it is taken as constant at its first value.
    omega : rad/s.
    highest : at most `order`, which is the default.
    """
    highest = order if highest is None else highest
    first = float(signal[0])
    states = respond(sampled_filter(omega * dt, order), (signal - first)[:, None], np.zeros(order))
    if highest == order:
        top = signal - first - states @ [comb(order, k) for k in range(order)]
        states = np.column_stack([states, top])
    found = states[:, : highest + 1] * omega ** np.arange(highest + 1)
    found[:, 0] += first
    return found


def transients(n: int, dt: float, omega: float, order: int = 4) -> NDArray[np.float64]:
    """Columns (N, order) that span the filter's free response: (omega t)^k exp(-omega t)/k!."""
    tau = omega * dt * np.arange(n)
    columns = [np.exp(-tau)]
    for k in range(1, order):
        columns.append(columns[-1] * tau / k)
    return np.column_stack(columns)
