"""Linear time-invariant systems in discrete time: exact discretisation by holds, and their response."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

HOLDS = ("zero", "linear", "euler")


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


def noise_gains(system: Discrete, noisy: int = 0) -> NDArray[np.float64]:
    """Standard deviation (n,) of the states in steady state for unit white noise on input `noisy`, sample by sample.

    Raises
    ------
    ValueError : if the system is not stable (there is no steady state).
    """
    from scipy.linalg import solve_discrete_lyapunov

    if np.abs(np.linalg.eigvals(system.a)).max() >= 1.0:
        raise ValueError("the observer is not stable at this sampling step")
    now, ahead = system.now[:, noisy], system.ahead[:, noisy]
    # x[k] = y[k] + ahead u[k], y[k+1] = a y[k] + (now + a ahead) u[k]: y[k] and u[k] are independent
    drive = now + system.a @ ahead
    unit = np.where(np.abs(drive) > 0.0, np.abs(drive), 1.0)  # similar states keep the equation well conditioned
    variance = solve_discrete_lyapunov(system.a * unit / unit[:, None], np.outer(drive / unit, drive / unit))
    return np.sqrt(np.diag(variance) * unit**2 + ahead**2)
