"""What a record is worth under gusts: forces in the proportions of gusts, at the cost of their parameters.

Noise forces of any proportions take a faint cause up; gusts act on surge, sway and yaw at once, and records that a
cause leaves calm need no gusts at all.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np

from ..methods.innovations.estimator import Estimator, Innovations, Setting

GUST_X, GUST_Y = (1.0, 2.7), (2.2, 12.0)
"""Range of the sd of gusts in surge and in sway over that in yaw (moment over L), from hulls and superstructures."""
COARSE = np.linspace(np.log(0.02), np.log(1.5), 7)
"""Logs of the yaw force's sd where the best gusts are looked for, over the largest that one fitted force calls for."""
FINE = 0.01
"""To what the log of the best gusts' sd is found: strong gusts' likelihood falls by nats within a tenth."""


@dataclass(frozen=True)
class Judged:
    """The records at a setting, now their innovations, by what noise like gusts makes of them (log likelihoods)."""

    est: Estimator
    setting: Setting
    now: Innovations

    @cached_property
    def calm(self) -> float:
        """Without gusts."""
        return _calm(self.est, self.setting, self.now)

    @cached_property
    def gust_like(self) -> float:
        """Of the best noise whose forces are in the proportions of gusts, or zero."""
        return max(self.calm, _proportioned(self.est, self.setting, self.now))

    @property
    def worth(self) -> float:
        """Without gusts, or under the best gusts less their cost."""
        if self.now.log_likelihood - cost(self.est) <= self.calm:  # in proportion they gain no more
            return self.calm
        return max(self.calm, self.gust_like - cost(self.est))


def cost(est: Estimator) -> float:
    """One nat for each parameter of gusts: their sds and the correlation time (Akaike 1974)."""
    return est.n_forces + 1.0


def worth(est: Estimator, s: Setting, now: Innovations) -> float:
    """What the records are worth at a setting; see `Judged.worth`."""
    return Judged(est, s, now).worth


def _calm(est: Estimator, s: Setting, now: Innovations) -> float:
    if not s.noise[6 : 6 + est.n_forces].any():
        return now.log_likelihood
    still = _forced(s, np.zeros(est.n_forces))
    return min(est.evaluate(still).log_likelihood, now.log_likelihood)


def _proportioned(est: Estimator, s: Setting, now: Innovations) -> float:
    if est.n_forces != 3:
        return now.log_likelihood
    x, y, n = s.noise[6:9]
    if _within(x, n, GUST_X) and _within(y, n, GUST_Y):
        return now.log_likelihood
    from scipy.optimize import minimize_scalar

    largest = max(n, y / GUST_Y[0], x / GUST_X[0])

    def gust(log_yaw: float) -> Setting:
        yaw = largest * np.exp(log_yaw)
        return _forced(s, [np.clip(x, *np.multiply(GUST_X, yaw)), np.clip(y, *np.multiply(GUST_Y, yaw)), yaw])

    found = [i.log_likelihood for i in est.many([gust(at) for at in COARSE])]
    best = int(np.argmax(found))
    around = COARSE[max(best - 1, 0)], COARSE[min(best + 1, len(COARSE) - 1)]
    fine: Any = minimize_scalar(
        lambda at: -est.evaluate(gust(at)).log_likelihood, bounds=around, method="bounded", options={"xatol": FINE}
    )
    return min(max(found[best], -float(fine.fun)), now.log_likelihood)


def _forced(s: Setting, sd: Sequence[float] | np.ndarray) -> Setting:
    """The setting with other sds of the forces."""
    noise = s.noise.copy()
    noise[6 : 6 + len(sd)] = sd
    return replace(s, noise=noise)


def _within(sd: float, yaw: float, ratio: tuple[float, float]) -> bool:
    return bool(ratio[0] * yaw <= sd <= ratio[1] * yaw)
