"""The exact inverse map of a difference equation: the continuous model that has its samples under a held rudder.

Forward differences fit the difference equation r(t+1) = a1 r(t) + ... exactly, but convert its coefficients by the
explicit Euler rule (paper 002, eq 4 and 6).  Here the matrix logarithm of the sampled system gives the continuous one.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ....datasets.record import Record
from ....models.errors import CannotFit, FitFailed
from ....models.model import Model
from ...records.series import steps
from ...regression.integrated import Roles, roles
from ...results.fit import mapped

STEP = 1e-6
"""Relative step of the central differences in the map's Jacobian."""


def common_step(records: Sequence[Record]) -> float:
    """The one time step of all records, s.

    Raises
    ------
    CannotFit : the steps are not equal.
    """
    found = np.concatenate([steps(record)[:1] for record in records])
    if not all(record.uniform() for record in records) or np.ptp(found) > 1e-3 * found[0]:
        raise CannotFit("the zoh map needs equal time steps in all records")
    return float(np.median(found))


def exact(coefficients: np.ndarray, model: Model, dt: float) -> np.ndarray:
    """Coefficients (p,) of the continuous model whose samples obey the Euler difference equation of `coefficients`.

    The rudder is held over the step dt (s).  Terms in functions of the yaw rate keep their static gain.

    Raises
    ------
    CannotFit : the model is no response model.
    FitFailed : a discrete pole lies at or below zero, where no continuous pole belongs to it.
    """
    found = roles(model)
    return _second(coefficients, found, dt) if found.order == 2 else _first(coefficients, found, dt)


def _first(c: np.ndarray, found: Roles, dt: float) -> np.ndarray:
    """r(t+1) = (1 + dt a) r(t) + ...: the logarithm of the pole; the other coefficients in proportion."""
    if "r" not in found.linear:
        return c
    i, factor = found.linear["r"]
    pole = 1.0 + dt * factor * c[i]
    if not pole > 0.0:
        raise FitFailed(f"the discrete pole {pole:.4g} has no logarithm")
    return c if pole == 1.0 else c * np.log(pole) / (pole - 1.0)


def _second(c: np.ndarray, found: Roles, dt: float) -> np.ndarray:
    """Block matrix logarithm of w(t+1) = w + dt (a1 (w + b2 d) + a2 r + b1 d), r(t+1) = r + dt (w + b2 d)."""
    from scipy.linalg import logm

    a1, a2, b1, b2 = (c[i] * factor for i, factor in (found.linear[s] for s in ("q", "r", "delta", "delta_rate")))
    rate = np.array([[a1, a2, a1 * b2 + b1], [1.0, 0.0, b2], [0.0, 0.0, 0.0]])
    sampled = np.eye(3) + dt * rate
    poles = np.linalg.eigvals(sampled[:2, :2])
    if np.any((np.abs(poles.imag) < 1e-12) & (poles.real <= 0.0)):
        raise FitFailed("a discrete pole at or below zero has no logarithm")
    continuous = np.real(np.asarray(logm(sampled))) / dt
    a, b = continuous[:2, :2], continuous[:2, 2]
    trace, determinant = a[0, 0] + a[1, 1], a[0, 0] * a[1, 1] - a[0, 1] * a[1, 0]
    mapped = {"q": trace, "r": -determinant, "delta_rate": b[1], "delta": a[1] @ b - trace * b[1]}
    result = c * (-determinant / a2)
    for symbol, value in mapped.items():
        i, factor = found.linear[symbol]
        result[i] = value / factor
    return result


def exact_with_covariance(
    c: np.ndarray, covariance: np.ndarray, model: Model, dt: float
) -> tuple[np.ndarray, np.ndarray]:
    """`exact` of c (p,), and its covariance (p, p) by the Jacobian of the map (delta method)."""
    jacobian = np.empty((c.size, c.size))
    for j in range(c.size):
        h = STEP * (abs(c[j]) or 1.0)
        move = np.eye(c.size)[j] * h
        jacobian[:, j] = (exact(c + move, model, dt) - exact(c - move, model, dt)) / (2.0 * h)
    found = mapped(jacobian, covariance)
    return exact(c, model, dt), (found + found.T) / 2.0
