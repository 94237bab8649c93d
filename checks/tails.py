"""Tails and quantiles of distributions by `scipy.special`.

`scipy.stats` has the same by their names, but takes half a second to import.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from scipy.special import chdtr, chdtrc, chdtri, chndtr, fdtrc, gammaln, log_ndtr, ndtr, ndtri, stdtr, stdtrit

INTERVAL = 0.95
"""Quantile of Student's t that a 90 % interval of a mean ends at."""


def chi2_tail(x: Any, k: float) -> Any:
    """P(chi2_k > x) for x >= 0."""
    return chdtrc(k, x)


def chi2_quantile(tail: float, k: float) -> float:
    """x with P(chi2_k > x) = tail."""
    return float(chdtri(k, tail))


def shifted_chi2_tail(x: float, k: float, noncentrality: float) -> float:
    """P(chi2_k(noncentrality) > x)."""
    return 1.0 - float(chndtr(x, k, noncentrality))


def normal_tail(x: float) -> float:
    """P(z > x) of a standard normal z."""
    return float(ndtr(-x))


def normal_log_tail(x: float) -> float:
    """log P(z > x) of a standard normal z."""
    return float(log_ndtr(-x))


def normal_quantile(p: float) -> float:
    """x with P(z <= x) = p of a standard normal z."""
    return float(ndtri(p))


def student_tail(x: float, dof: float) -> float:
    """P(t_dof > x)."""
    return float(stdtr(dof, -x))


def student_quantile(p: float, dof: float) -> float:
    """x with P(t_dof <= x) = p."""
    return float(stdtrit(dof, p))


def half_of_mean(values: np.ndarray) -> float:
    """Half of the 90 % interval of the mean of values (N,), two at least."""
    return student_quantile(INTERVAL, values.size - 1) * float(np.std(values, ddof=1)) / np.sqrt(values.size)


def f_tail(x: float, k: float, dof: float) -> float:
    """P(F_k,dof > x); 1 for x <= 0."""
    return float(fdtrc(k, dof, max(x, 0.0)))


def log_tail(statistic: float, k: int) -> float:
    """log P(chi2_k > statistic), also far in the tail."""
    x = max(float(statistic), 1e-9)
    if x < 300.0:
        tail = float(chdtrc(k, x))
        return float(np.log(tail) if tail < 0.5 else np.log1p(-chdtr(k, x)))
    return float(-0.5 * x + (0.5 * k - 1.0) * np.log(0.5 * x) - gammaln(0.5 * k))


def adjusted(log_p: float, tests: float) -> float:
    """A p-value adjusted for independent tests."""
    return float(min(1.0, tests * np.exp(max(log_p, -700.0))))
