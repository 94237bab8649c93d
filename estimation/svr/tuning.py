"""Choosing the regularisation constant C by validation error."""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import numpy as np

DOMAIN = (1e-2, 1e10)
"""Search domain of C (paper 003, Table 3)."""
POINTS = 25

Objective = Callable[[float], float]
"""C -> validation error, to be minimised; inf where the fit fails."""


class Tuned(NamedTuple):
    """The best value found, its error, and how often the objective was called."""

    value: float
    error: float
    evaluations: int


Tuner = Callable[[Objective, float, float], Tuned]
"""Searches [low, high] on a logarithmic scale."""


def grid(objective: Objective, low: float = DOMAIN[0], high: float = DOMAIN[1], points: int = POINTS) -> Tuned:
    """The best of `points` values in geometric progression; among equal ones the smallest."""
    values = np.geomspace(low, high, points)
    errors = np.array([objective(float(value)) for value in values])
    errors = np.where(np.isfinite(errors), errors, np.inf)
    best = int(np.argmin(errors))
    return Tuned(float(values[best]), float(errors[best]), points)


TUNERS: dict[str, Tuner] = {"grid": grid}
