"""Linear time-invariant systems in discrete time: exact discretisation by holds, their response, a filter of channels.

The state-variable filter gives derivatives of a sampled signal, all with the same lag: every signal of a linear
differential equation passes through the same F(s) = omega^n/(s + omega)^n.  The equation then holds for the filtered
signals as it does for the signals themselves, at every omega; s^k F gives the derivatives (Young 1981, state-variable
filters).  The derivatives of an observer, in contrast, lag by different times.
"""

from __future__ import annotations

from functools import lru_cache
from math import comb
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

HOLDS = ("zero", "linear", "euler")
BLOCK = 4096
"""Samples that are filtered at a time."""


class Discrete(NamedTuple):
    """x[k+1] = a x[k] + now u[k] + ahead u[k+1]; a (n, n), now and ahead (n, m)."""

    a: NDArray[np.float64]
    now: NDArray[np.float64]
    ahead: NDArray[np.float64]


def discretised(a: ArrayLike, b: ArrayLike, dt: float, hold: str = "linear") -> Discrete:
    """x' = a x + b u over samples of dt seconds.

    Parameters
    ----------
    a, b : (n, n) and (n, m).
    hold : the input between samples, exactly solved: 'zero' (held) or 'linear' (first-order hold); or 'euler', one
        explicit step a sample.

    Raises
    ------
    ValueError : for an unknown hold.
    """
    from scipy.linalg import expm

    a, b = np.asarray(a, float), np.asarray(b, float)
    (n, m) = b.shape
    if hold == "euler":
        return Discrete(np.eye(n) + dt * a, dt * b, np.zeros((n, m)))
    if hold not in HOLDS:
        raise ValueError(f"unknown hold {hold!r}; known: {', '.join(HOLDS)}")
    block = np.zeros((n + 2 * m, n + 2 * m))
    block[:n, :n], block[:n, n : n + m], block[n : n + m, n + m :] = a * dt, b * dt, np.eye(m)
    exact = np.asarray(expm(block), float)
    level, slope = exact[:n, n : n + m], exact[:n, n + m :]
    if hold == "zero":
        return Discrete(exact[:n, :n], level, np.zeros((n, m)))
    return Discrete(exact[:n, :n], level - slope, slope)


def respond(system: Discrete, inputs: NDArray[np.float64], x0: ArrayLike) -> NDArray[np.float64]:
    """States (N, n) from x0 (n,) under inputs (N, m)."""
    from . import _kernels

    inputs = np.require(inputs, dtype=float, requirements=["C", "W"])
    states = np.empty((len(inputs), len(system.a)))
    a, now, ahead = (np.ascontiguousarray(part) for part in system)
    _kernels.linear_recursion(a, now, ahead, inputs, np.array(x0, float), states)
    return states


def noise_gains(system: Discrete) -> NDArray[np.float64]:
    """Standard deviation (n,) of the states in steady state for unit white noise on the first input, sample by sample.

    Raises
    ------
    ValueError : if the system is not stable (there is no steady state).
    """
    from scipy.linalg import solve_discrete_lyapunov

    if np.abs(np.linalg.eigvals(system.a)).max() >= 1.0:
        raise ValueError("the observer is not stable at this sampling step")
    now, ahead = system.now[:, 0], system.ahead[:, 0]
    # x[k] = y[k] + ahead u[k], y[k+1] = a y[k] + (now + a ahead) u[k]: y[k] and u[k] are independent
    drive = now + system.a @ ahead
    unit = np.where(np.abs(drive) > 0.0, np.abs(drive), 1.0)  # similar states keep the equation well conditioned
    variance = solve_discrete_lyapunov(system.a * unit / unit[:, None], np.outer(drive / unit, drive / unit))
    return np.sqrt(np.diag(variance) * unit**2 + ahead**2)


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
    signal: NDArray[np.float64], dt: float, omega: float, order: int = 4, highest: int | None = None, every: int = 1
) -> NDArray[np.float64]:
    """s^k F(s) signal for k = 0 .. highest, as columns (N, highest + 1), in units of the signal per second^k.

    Blocks are filtered one after the other, each of which fits in a processor's cache.

    Parameters
    ----------
    signal : samples without gaps.  Before the record it is taken as constant at its first value.
    omega : rad/s.
    highest : at most `order`, which is the default.
    every : rows of every so many samples, from the first one on.
    """
    highest = order if highest is None else highest
    system, x = sampled_filter(omega * dt, order), np.zeros(order)
    columns = np.empty((-(-len(signal) // every), highest + 1))
    block = every * max(1, BLOCK // every)
    for start in range(0, len(signal), block):
        rise = signal[start : start + block + 1] - signal[0]
        states = respond(system, rise[:, None], x)
        x, thin = states[-1], states[:block:every]
        rows = columns[start // every :][: len(thin)]
        rows[:, :order] = thin[:, : highest + 1]
        if highest == order:
            rows[:, order] = rise[:block:every] - thin @ [comb(order, k) for k in range(order)]
    columns *= omega ** np.arange(highest + 1)
    columns[:, 0] += signal[0]
    return columns


def transients(n: int, dt: float, omega: float, order: int = 4) -> NDArray[np.float64]:
    """Columns (N, order) that span the filter's free response: (omega t)^k exp(-omega t)/k!."""
    tau = omega * dt * np.arange(n)
    columns = [np.exp(-tau)]
    for k in range(1, order):
        columns.append(columns[-1] * tau / k)
    return np.column_stack(columns)
