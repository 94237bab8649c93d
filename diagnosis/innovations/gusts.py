"""Penalised log likelihood of records under gusts: forces in the proportions of gusts, less the cost of their
parameters.

Random forces of any proportions absorb a faint cause; gusts act on surge, sway and yaw at once, and records that a
cause leaves calm need no gusts at all.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np

from ...estimation.filters.innovations.estimator import Estimator, Innovations
from ...estimation.filters.innovations.settings import Setting

GUST_X, GUST_Y = (1.0, 2.7), (2.2, 12.0)
"""Range of the sd of gusts in surge and in sway over that in yaw (moment over L), from hulls and superstructures."""
COARSE = np.linspace(np.log(0.02), np.log(1.5), 7)
"""Logs of the yaw force's sd where the best gusts are looked for, over the largest that one fitted force calls for."""
FINE = 0.01
"""Accuracy of the log of the best gusts' sd: strong gusts' likelihood falls by nats within a tenth."""


@dataclass(frozen=True)
class GustLikelihood:
    """Log likelihoods of the records at a setting, now their innovations, under forces like gusts."""

    est: Estimator
    setting: Setting
    now: Innovations

    @cached_property
    def calm(self) -> float:
        """Without random forces."""
        if not self.setting.noise.has_forces:
            return self.now.log_likelihood
        still = replace(self.setting, noise=self.setting.noise.without_forces())
        return min(self.est.evaluate(still).log_likelihood, self.now.log_likelihood)

    @cached_property
    def gusty(self) -> float:
        """Of the best random forces in the proportions of gusts, or none."""
        return max(self.calm, _proportioned(self.est, self.setting, self.now))

    @property
    def penalised(self) -> float:
        """Without random forces, or under the best gusts less their cost."""
        if self.now.log_likelihood - gust_cost(self.est) <= self.calm:  # in proportion they gain no more
            return self.calm
        return max(self.calm, self.gusty - gust_cost(self.est))


def gust_cost(est: Estimator) -> float:
    """One nat for each parameter of gusts: their sds and the correlation time (Akaike 1974)."""
    return est.n_forces + 1.0


def penalised_likelihood(est: Estimator, s: Setting, now: Innovations) -> float:
    """See `GustLikelihood.penalised`."""
    return GustLikelihood(est, s, now).penalised


def _proportioned(est: Estimator, s: Setting, now: Innovations) -> float:
    if est.n_forces != 3:
        return now.log_likelihood
    x, y, n = s.noise.force_sd
    if _within(x, n, GUST_X) and _within(y, n, GUST_Y):
        return now.log_likelihood
    from scipy.optimize import minimize_scalar

    largest = max(n, y / GUST_Y[0], x / GUST_X[0])

    def gust(log_yaw: float) -> Setting:
        yaw = largest * np.exp(log_yaw)
        return _forced(s, [np.clip(x, *np.multiply(GUST_X, yaw)), np.clip(y, *np.multiply(GUST_Y, yaw)), yaw])

    likelihoods = [i.log_likelihood for i in est.many([gust(at) for at in COARSE])]
    best = int(np.argmax(likelihoods))
    around = COARSE[max(best - 1, 0)], COARSE[min(best + 1, len(COARSE) - 1)]
    fine: Any = minimize_scalar(
        lambda at: -est.evaluate(gust(at)).log_likelihood, bounds=around, method="bounded", options={"xatol": FINE}
    )
    return min(max(likelihoods[best], -float(fine.fun)), now.log_likelihood)


def _forced(s: Setting, sd: Sequence[float]) -> Setting:
    """The setting with other sds of the random forces."""
    return replace(s, noise=replace(s.noise, force_sd=np.array(sd, float)))


def _within(sd: float, yaw: float, ratio: tuple[float, float]) -> bool:
    return bool(ratio[0] * yaw <= sd <= ratio[1] * yaw)
