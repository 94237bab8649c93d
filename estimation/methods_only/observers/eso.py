"""Linear extended state observer of the heading (paper 003, eq 8-20, corrected; the printed form is separate).

States psi, r, psi_ddot and z5, the part of psi_dddot that b0 u does not explain, driven by e = psi - z1:

    z1' = z2 + l1 e,  z2' = z4 + l2 e,  z4' = z5 + b0 u + l4 e,  z5' = l5 e

with characteristic polynomial s^4 + l1 s^3 + l2 s^2 + l4 s + l5.  psi_dddot is estimated by z5 + b0 u.  z5 lags the
heading by 4/omega0, the other states by less; `observers.linear` has a filter with one lag for all derivatives.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ...observers.linear import Discrete, discretised, respond

PRINTED_OMEGA = 45.0
"""rad/s; Table 3's gains are those of (s + 45)^4."""
PRINTED_L3 = 100.0
METHODS = ("exact", "euler")


class Observed(NamedTuple):
    """Estimates (N,) of heading, yaw rate and its two derivatives; rudder and its slope in the printed form."""

    psi: NDArray[np.float64]
    r: NDArray[np.float64]
    psi_ddot: NDArray[np.float64]
    psi_dddot: NDArray[np.float64]
    delta: NDArray[np.float64] | None = None
    delta_dot: NDArray[np.float64] | None = None


def gains(poles: ArrayLike) -> NDArray[np.float64]:
    """l1, l2, l4, l5 (4,) that place the four poles (eq 20; all six pair products in l2).

    Raises
    ------
    ValueError : unless they are four, with negative real parts, and real or in conjugate pairs.
    """
    poles = np.asarray(poles, complex)
    polynomial = np.poly(poles)
    if poles.shape != (4,) or (np.real(poles) >= 0.0).any() or np.abs(np.imag(polynomial)).max() > 0.0:
        raise ValueError("four poles with negative real parts, real or in conjugate pairs, are needed")
    return np.real(polynomial[1:]).astype(float)


def observer(gain: ArrayLike, b0: float = 0.0) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """a (4, 4) and b (4, 2) of the states (psi, r, psi_ddot, z5) driven by (psi, u)."""
    l1, l2, l4, l5 = np.asarray(gain, float)
    a = np.array([[-l1, 1.0, 0.0, 0.0], [-l2, 0.0, 1.0, 0.0], [-l4, 0.0, 0.0, 1.0], [-l5, 0.0, 0.0, 0.0]])
    b = np.array([[l1, 0.0], [l2, 0.0], [l4, b0], [l5, 0.0]])
    return a, b


def sampled_observer(omega0: float, dt: float, method: str = "exact", b0: float = 0.0) -> Discrete:
    """The observer in samples, inputs (psi, u) held.

    Parameters
    ----------
    method : 'exact' (the chain of integrators over dt solved exactly, all poles at exp(-omega0 dt), so stable for every
        omega0), or 'euler' (one explicit step a sample, as the paper computes it).

    Raises
    ------
    ValueError : for another method.
    """
    if method not in METHODS:
        raise ValueError(f"unknown method {method!r}; known: {', '.join(METHODS)}")
    if method == "euler":
        return discretised(*observer(gains([-omega0] * 4), b0), dt, "euler")
    unit = dt ** -np.arange(4.0)  # in units of dt the numbers below do not depend on it
    chain = discretised(np.eye(4, k=1), np.eye(4)[:, 2:3], 1.0, "zero")
    rows = [np.linalg.matrix_power(chain.a, k)[0] for k in range(4)]
    shifted = chain.a - np.exp(-omega0 * dt) * np.eye(4)
    gain = np.linalg.matrix_power(shifted, 4) @ np.linalg.solve(np.array(rows), np.eye(4)[:, 3])  # Ackermann
    a = chain.a - np.outer(gain, np.eye(4)[0])
    now = np.column_stack([gain * unit, chain.now[:, 0] * unit * dt**3 * b0])
    return Discrete(a * unit[:, None] / unit, now, np.zeros((4, 2)))


def printed_observer(
    gain: ArrayLike, l3: float, kp: float, lag_s: float
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """a (5, 5) and b (5, 2) of eq 8 as printed: states (psi, r, rudder, psi_ddot, z5), inputs (psi, heading reference).

    b0 is 1 and the rudder follows the helmsman kp (u - z1) through a lag, corrected by l3 e.
    """
    l1, l2, l4, l5 = np.asarray(gain, float)
    a = np.array(
        [
            [-l1, 1.0, 0.0, 0.0, 0.0],
            [-l2, 0.0, 0.0, 1.0, 0.0],
            [-kp / lag_s - l3, 0.0, -1.0 / lag_s, 0.0, 0.0],
            [-l4, 0.0, 0.0, 0.0, 1.0],
            [-l5, 0.0, 0.0, 0.0, 0.0],
        ]
    )
    b = np.array([[l1, 0.0], [l2, 0.0], [l3, kp / lag_s], [l4, 1.0], [l5, 0.0]])
    return a, b


def observe(
    psi: NDArray[np.float64],
    dt: float,
    omega0: float,
    method: str = "exact",
    b0: float = 0.0,
    u: NDArray[np.float64] | None = None,
) -> Observed:
    """The corrected observer along headings (N,) sampled every dt seconds, started at the first.

    Parameters
    ----------
    omega0 : rad/s; all four poles lie at -omega0.
    method : 'exact' or 'euler', see `sampled_observer`.
    b0, u : gain and samples (N,) of an input that the observer knows.
    """
    u = np.zeros(len(psi)) if u is None else u
    system = sampled_observer(omega0, dt, method, b0)
    z = respond(system, np.column_stack([psi, u]), [psi[0], 0.0, 0.0, -b0 * u[0]])
    return Observed(z[:, 0], z[:, 1], z[:, 2], z[:, 3] + b0 * u)


def observe_as_printed(
    psi: NDArray[np.float64],
    reference: NDArray[np.float64],
    dt: float,
    kp: float,
    lag_s: float,
    omega0: float = PRINTED_OMEGA,
) -> Observed:
    """Eq 8 as printed by explicit Euler, from rest: headings and heading references (N,) sampled every dt seconds.

    The rudder's slope is that of the steering gear at the observer's own states.
    """
    system = discretised(*printed_observer(gains([-omega0] * 4), PRINTED_L3, kp, lag_s), dt, "euler")
    z = respond(system, np.column_stack([psi, reference]), np.zeros(5))
    slope = (kp * (reference - z[:, 0]) - z[:, 2]) / lag_s
    return Observed(z[:, 0], z[:, 1], z[:, 3], z[:, 4] + reference, z[:, 2], slope)
