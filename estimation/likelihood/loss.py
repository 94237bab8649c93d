"""Robust losses of residuals in units of their channel's scale, which is estimated together with the coefficients."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ...models.errors import BadInput

ROUNDS = 100
"""Iterations of the scale at most."""
TUNING = {"huber": 1.345, "student": 4.0}
"""Default tuning constants: bend of Huber's loss in standard deviations (95 % efficient for Gaussian noise), degrees
of freedom of Student's distribution."""


class Loss(NamedTuple):
    """rho(u) of standardised residuals u: `huber` (quadratic up to `tuning`, then linear), `student` (the negative log
    density of Student's t with `tuning` degrees of freedom) or `tukey` (the biweight, level beyond `tuning`).

    Huber 1964, Ann. Math. Stat. 35, 73; Lange, Little & Taylor 1989, J. Am. Stat. Assoc. 84, 881; Beaton & Tukey 1974,
    Technometrics 16, 147.
    """

    kind: str
    tuning: float

    def rho(self, u: np.ndarray) -> np.ndarray:
        if self.kind == "huber":
            size = np.abs(u)
            return np.where(size <= self.tuning, 0.5 * u**2, self.tuning * (size - 0.5 * self.tuning))
        if self.kind == "tukey":
            return self.tuning**2 / 6.0 * (1.0 - np.maximum(1.0 - (u / self.tuning) ** 2, 0.0) ** 3)
        return 0.5 * (self.tuning + 1.0) * np.log1p(u**2 / self.tuning)

    def weight(self, u: np.ndarray) -> np.ndarray:
        """rho'(u)/u, the weight of a residual's square."""
        if self.kind == "huber":
            return self.tuning / np.maximum(np.abs(u), self.tuning)
        if self.kind == "tukey":
            return np.maximum(1.0 - (u / self.tuning) ** 2, 0.0) ** 2
        return (self.tuning + 1.0) / (self.tuning + u**2)

    def curvature(self, u: np.ndarray) -> np.ndarray:
        """rho''(u)."""
        if self.kind == "huber":
            return (np.abs(u) <= self.tuning).astype(float)
        if self.kind == "tukey":
            inside = np.maximum(1.0 - (u / self.tuning) ** 2, 0.0)
            return inside * (5.0 * inside - 4.0)
        return (self.tuning + 1.0) * (self.tuning - u**2) / (self.tuning + u**2) ** 2

    @property
    def consistency(self) -> float:
        """E[u rho'(u)] of a standard normal u for Huber's loss, so that the scale is its standard deviation; 1 for
        Student's, whose scale is that of the distribution."""
        if self.kind == "student":
            return 1.0
        from math import erf, exp, pi, sqrt

        k = self.tuning
        inside = erf(k / sqrt(2.0)) - 2.0 * k * exp(-0.5 * k * k) / sqrt(2.0 * pi)
        return inside + 2.0 * k * exp(-0.5 * k * k) / sqrt(2.0 * pi)

    def scale(self, errors: np.ndarray, floor: float) -> float:
        """Scale s of residuals (N,): the minimum of N consistency log s + sum rho(e/s); at least `floor`."""
        s = max(float(np.median(np.abs(errors))) / 0.6745, floor)
        for _ in range(ROUNDS):
            before = s
            square = float(np.mean(self.weight(errors / s) * errors**2)) / self.consistency
            s = max(np.sqrt(square), floor)
            if abs(s - before) <= 1e-10 * s:
                break
        return s

    def moments(self, u: np.ndarray) -> tuple[float, float]:
        """Means of rho'' and of rho'^2, which the covariances and likelihood ratios of M-estimation need."""
        slope = self.weight(u) * u
        return float(np.mean(self.curvature(u))), float(max(np.mean(slope**2), 1e-300))


def loss_of(name: str | None, tuning: float | None) -> Loss | None:
    """The loss that the options `loss` and `tuning` name; None for least squares.

    Raises
    ------
    BadInput : for an unknown name or a tuning constant that is not positive.
    """
    if name in (None, "gauss"):
        if tuning is not None:
            raise BadInput("tuning is for a robust loss", hint="add loss=huber or loss=student")
        return None
    if name not in TUNING:
        raise BadInput(f"unknown loss {name!r}", hint=f"known: gauss, {', '.join(TUNING)}")
    value = TUNING[name] if tuning is None else tuning
    if isinstance(value, bool) or not isinstance(value, int | float) or not (0.0 < value < np.inf):
        raise BadInput(f"tuning is {tuning!r}, a positive number is needed")
    return Loss(name, float(value))
