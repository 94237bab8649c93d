"""Choosing the regularisation constant C by validation error."""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import numpy as np

DOMAIN = (1e-2, 1e10)
"""Search domain of C (paper 003, Table 3)."""
POINTS = 25
CYCLES = 30
"""Of the colony of paper 003, Table 3."""

Objective = Callable[[float], float]
"""C -> validation error, to be minimised; inf where the fit fails."""


class TunedConstant(NamedTuple):
    """The best value found, its error, and how often the objective was called."""

    value: float
    error: float
    evaluations: int


Tuner = Callable[[Objective, float, float], TunedConstant]
"""Searches [low, high] on a logarithmic scale."""


def grid(objective: Objective, low: float = DOMAIN[0], high: float = DOMAIN[1], points: int = POINTS) -> TunedConstant:
    """The best of `points` values in geometric progression; among equal ones the smallest."""
    values = np.geomspace(low, high, points)
    errors = np.array([objective(float(value)) for value in values])
    errors = np.where(np.isfinite(errors), errors, np.inf)
    best = int(np.argmin(errors))
    return TunedConstant(float(values[best]), float(errors[best]), points)


def colony(
    objective: Objective, low: float = DOMAIN[0], high: float = DOMAIN[1], cycles: int = CYCLES
) -> TunedConstant:
    """The best that the artificial bee colony of paper 003 finds (Table 3): 30 sources, and 60 moves in every cycle."""
    import optuna

    from ..tuning.abc import PAPER_003, ABCSampler
    from ..tuning.tune import quiet

    most = PAPER_003["n_sources"] + cycles * (PAPER_003["n_sources"] + PAPER_003["n_onlookers"])
    with quiet():
        study = optuna.create_study(sampler=ABCSampler(**PAPER_003, seed=0))
        study.optimize(lambda trial: objective(trial.suggest_float("C", low, high, log=True)), n_trials=most)
    return TunedConstant(float(study.best_params["C"]), float(study.best_value), most)


TUNERS: dict[str, Tuner] = {"grid": grid, "abc": colony}
