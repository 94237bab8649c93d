"""What a record is worth under gusts: forces in the proportions of gusts, at the cost of their parameters.

Noise forces of any proportions take a faint cause up; gusts act on surge, sway and yaw at once, and records that a
cause leaves calm need no gusts at all.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from ..methods.innovations.estimator import Estimator, Innovations, Setting

GUST_X, GUST_Y = (1.0, 2.7), (2.2, 12.0)
"""Range of the sd of gusts in surge and in sway over that in yaw (moment over L), from hulls and superstructures."""


def gust_like(est: Estimator, s: Setting, now: Innovations) -> float:
    """Log likelihood of the best noise whose forces are in the proportions of gusts, or zero."""
    return max(_calm(est, s, now), _proportioned(est, s, now))


def worth(est: Estimator, s: Setting, now: Innovations) -> float:
    """Log likelihood without gusts, or of the best gusts less one nat for each of their parameters (Akaike 1974)."""
    return max(_calm(est, s, now), _proportioned(est, s, now) - (est.n_forces + 1.0))


def _calm(est: Estimator, s: Setting, now: Innovations) -> float:
    forces = slice(6, 6 + est.n_forces)
    if not s.noise[forces].any():
        return now.log_likelihood
    noise = s.noise.copy()
    noise[forces] = 0.0
    return min(est.evaluate(replace(s, noise=noise)).log_likelihood, now.log_likelihood)


def _proportioned(est: Estimator, s: Setting, now: Innovations) -> float:
    if est.n_forces != 3:
        return now.log_likelihood
    x, y, n = s.noise[6:9]
    if _within(x, n, GUST_X) and _within(y, n, GUST_Y):
        return now.log_likelihood
    largest = max(n, y / GUST_Y[0], x / GUST_X[0])
    settings = []
    for yaw in np.geomspace(0.02 * largest, 1.5 * largest, 20):
        noise = s.noise.copy()
        noise[6:9] = [np.clip(x, *np.multiply(GUST_X, yaw)), np.clip(y, *np.multiply(GUST_Y, yaw)), yaw]
        settings.append(replace(s, noise=noise))
    return min(max(i.log_likelihood for i in est.many(settings)), now.log_likelihood)


def _within(sd: float, yaw: float, ratio: tuple[float, float]) -> bool:
    return bool(ratio[0] * yaw <= sd <= ratio[1] * yaw)
