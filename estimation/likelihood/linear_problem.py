"""A least-squares problem linearised about one point: damped steps on its triangular factor."""

from __future__ import annotations

import numpy as np

from ...models.linear_algebra import lstsq, svd

NULL = 1e-12
"""Singular values (columns of unit length) below which a direction counts as not identified."""


class LinearProblem:
    """The weighted problem linearised about one point, in columns of unit length.

    factor (rows, width + 1) is the triangular factor of [derivatives | residuals]; length (width,) are the lengths of
    the columns where the factor does not hold all of their rows.
    """

    def __init__(self, factor: np.ndarray, length: np.ndarray | None = None) -> None:
        self.a, self.b = factor[:, :-1], factor[:, -1]
        full = np.linalg.norm(self.a, axis=0) if length is None else length
        self.length = np.where(full > 0.0, full, 1.0)
        u, s, vt = svd(self.a / self.length, full_matrices=False)
        kept = s > NULL * s[0]
        self.singular, self.projected = s[kept], (u.T @ self.b)[kept]
        self.back = vt[kept].T / self.length[:, None]

    def step(self, damping: float) -> tuple[np.ndarray, float]:
        """The damped step (width,), and the decrease of half the sum of squares that it predicts."""
        left = damping / (self.singular**2 + damping)
        step = self.back @ (self.singular / (self.singular**2 + damping) * self.projected)
        return step, float(0.5 * np.sum(self.projected**2 * (1.0 - left**2)))

    def solved(self, gradient: np.ndarray, damping: float) -> np.ndarray:
        """The damped normal equations' solution (width,) for a right-hand side (width,)."""
        return self.back @ ((self.back.T @ gradient) / (self.singular**2 + damping))

    def step_within(self, damping: float, low: np.ndarray, high: np.ndarray) -> tuple[np.ndarray, float]:
        """The same for a step between low and high (width,).

        Unknowns whose step would cross a bound are set on it, and the others are solved again.
        """
        inside = np.ones(self.length.size, bool)
        step = np.zeros(self.length.size)
        while inside.any():
            a = self.a[:, inside] / self.length[inside]
            rest = self.b - self.a[:, ~inside] @ step[~inside]
            damped = np.vstack([a, np.sqrt(damping) * np.eye(a.shape[1])])
            right = np.concatenate([rest, np.zeros(a.shape[1])])
            step[inside] = lstsq(damped, right, rcond=NULL) / self.length[inside]
            outside = inside & ((step < low) | (step > high))
            if not outside.any():
                break
            step[outside] = np.clip(step, low, high)[outside]
            inside &= ~outside
        return step, float(0.5 * (self.b @ self.b - np.sum((self.b - self.a @ step) ** 2)))
