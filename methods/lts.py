"""Least trimmed squares by concentration steps (FAST-LTS)."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from ..estimation.methods_only.regression.robust import huber_estimate
from ..estimation.methods_only.regression.weighted import RegressionRows, Reweighted
from ..estimation.methods_only.tuning.space import Real
from ..estimation.numerics import factors
from ..estimation.results.fit import Fit
from .base import RegressionMethod
from .options import number, option, whole

SAMPLE = 600
"""Samples that the random starts are tried on."""
TRIED, KEPT = 2, 3
"""Concentration steps of every random start, and how many starts are iterated to the end."""
CUT = 2.5
"""Scaled residual beyond which the final fit leaves out a row."""
MOST_STEPS = 30
"""Concentration steps at most."""


class Lts(RegressionMethod):
    """Least squares over the `coverage` share of rows that fit best, then over all rows within 2.5 standard deviations.

    Rousseeuw & Van Driessen 2006, Data Mining and Knowledge Discovery 12.  Rows are first divided by the spread of
    their equation's residuals under Huber's estimate.
    """

    name = "lts"
    title = "robust regression: least trimmed squares (FAST-LTS), reweighted"
    coverage: float = option(
        0.75,
        "share h/n of rows",
        number("a number above 0.5 and up to 1", lambda value: 0.5 < value <= 1.0),
        Real(0.55, 1.0),
    )
    starts: int = option(20, "random elemental starts, in addition to Huber's estimate", whole(0))
    seed: int = option(0, "seed of the generator that draws them", whole(0))

    def solve(self, rows: RegressionRows) -> Fit:
        huber = huber_estimate(rows)
        random = _random_starts(rows, huber, self.coverage, self.starts, np.random.default_rng(self.seed))
        found = [_concentrated(rows, huber.scale, c, self.coverage) for c in (huber.solution.x, *random)]
        best = min(found, key=lambda item: item[1])[0]
        return _reweighted_once(rows, best, huber.n_iterations)


def _random_starts(
    rows: RegressionRows, huber: Reweighted, coverage: float, count: int, rng: np.random.Generator
) -> Iterator[np.ndarray]:
    """The best few of `count` random starts, each after a few concentration steps on a sample of the rows."""
    y, phi = _sample(rows, huber, rng)
    h = int(np.ceil(coverage * y.size))
    tried = []
    size = rows.p // rows.used.size + 1
    for _ in range(count):
        chosen = rng.choice(len(y), min(size, len(y)), replace=False)
        x = _solve(y[chosen].ravel(), phi[chosen].reshape(-1, rows.p))
        objective = np.inf
        for _ in range(TRIED):
            error = (y - phi @ x).ravel() ** 2
            kept = np.argpartition(error, h - 1)[:h]
            x = _solve(y.ravel()[kept], phi.reshape(-1, rows.p)[kept])
            objective = float(np.partition((y - phi @ x).ravel() ** 2, h - 1)[:h].sum())
        if np.isfinite(x).all():
            tried.append((objective, x))
    yield from (x for _, x in sorted(tried, key=lambda item: item[0])[:KEPT])


def _solve(y: np.ndarray, phi: np.ndarray) -> np.ndarray:
    return factors.solve(factors.fold(factors.empty(phi.shape[1]), np.column_stack([phi, y]))).x


def _sample(rows: RegressionRows, huber: Reweighted, rng: np.random.Generator) -> tuple[np.ndarray, np.ndarray]:
    """At most `SAMPLE` scaled rows (n, k), (n, k, p), sorted by residual: the order of records does not matter."""
    scale = huber.scale
    order = np.argsort(np.abs(rows.residuals(huber.solution.x) / scale).sum(axis=1), kind="stable")
    if len(order) > SAMPLE:
        order = order[np.sort(rng.choice(len(order), SAMPLE, replace=False))]
    y, phi = np.empty((rows.n, rows.used.size)), np.empty((len(order), rows.used.size, rows.p))
    place = np.full(rows.n, -1)
    place[order] = np.arange(len(order))
    for cut, left, right in rows.blocks():
        y[cut] = left
        chosen = place[cut] >= 0
        phi[place[cut][chosen]] = right[chosen]
    return y[order] / scale, phi / scale[:, None]


def _concentrated(rows: RegressionRows, scale: np.ndarray, c: np.ndarray, coverage: float) -> tuple[np.ndarray, float]:
    """Concentration steps from c to a fixed point; the coefficients (p,) and their trimmed sum of squares."""
    best, error = np.inf, (rows.residuals(c) / scale) ** 2
    h = int(np.ceil(coverage * error.size))
    for _ in range(MOST_STEPS):
        limit = np.partition(error.ravel(), h - 1)[h - 1]
        x = factors.solve(rows.factor((error <= limit) / scale**2)).x
        error = (rows.residuals(x) / scale) ** 2
        total = float(np.partition(error.ravel(), h - 1)[:h].sum())
        if not total < best * (1.0 - 1e-12):
            break
        best, c = total, x
    return c, best


def _reweighted_once(rows: RegressionRows, c: np.ndarray, n_iterations: int) -> Fit:
    """Least squares over the rows within `CUT` spreads of the trimmed fit."""
    from scipy.stats import chi2, norm

    error = rows.residuals(c)
    spread = rows.scale(error)
    kept = np.abs(error) <= CUT * spread
    solution = factors.solve(rows.factor(kept / spread**2))
    left = rows.residuals(solution.x)
    share = 2.0 * norm.cdf(CUT) - 1.0
    variance = (left**2 * kept).sum(axis=0) / np.maximum(kept.sum(axis=0) - solution.rank / len(spread), 1.0)
    variance *= share / chi2.cdf(CUT**2, 3)  # consistency factor for Gaussian errors cut off at CUT
    noise = float(np.mean(variance / spread**2)) / share
    return Fit(
        solution.x,
        solution.covariance * noise,
        n_iterations=n_iterations,
        extra={"residual_sd": np.sqrt(variance).tolist(), "rank": solution.rank, "outliers": float(1.0 - kept.mean())},
    )
