"""Robust regression: M-estimators by iteratively reweighted least squares, and least trimmed squares (FAST-LTS)."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from ..estimation.likelihood.loss import Loss
from ..estimation.methods_only.regression.weighted import RegressionRows, Reweighted, reweighted
from ..estimation.methods_only.tuning.space import Real
from ..estimation.numerics import factors
from ..estimation.results.fit import Fit
from .base import RegressionMethod, method
from .options import POSITIVE, number, option, whole

EFFICIENT = 1.345
"""Huber's k with 95 % efficiency on Gaussian noise."""
OUTLIER = 0.5
"""Weight below which a residual counts as an outlier."""


def huber_estimate(rows: RegressionRows) -> Reweighted:
    """Huber's estimate from that of least squares: the start of the other robust methods."""
    return reweighted(rows, rows.start.coefficients, Loss("huber", EFFICIENT).weight)


def m_estimate(rows: RegressionRows, loss: Loss, start: Reweighted | None = None) -> Fit:
    """M-estimate with its asymptotic covariance.

    start : estimate that a loss with several minima starts from, whose scale of the residuals is kept; None starts
    from least squares and computes the scale again in each iteration.
    """
    if start is None:
        found, before = reweighted(rows, rows.start.coefficients, loss.weight), 0
    else:
        found, before = reweighted(rows, start.solution.x, loss.weight, start.scale), start.n_iterations
    solution, count = found.solution, before + found.n_iterations
    weights = loss.weight(rows.residuals(solution.x) / found.scale)
    return Fit(
        solution.x,
        m_covariance(rows, found.scale, solution.x, loss),
        found.converged,
        "" if found.converged else f"not converged after {count} iterations",
        count,
        extra={
            "residual_sd": found.scale.tolist(),
            "rank": solution.rank,
            "outliers": float((weights < OUTLIER).mean()),
        },
    )


def m_covariance(rows: RegressionRows, scale: np.ndarray, c: np.ndarray, loss: Loss) -> np.ndarray:
    """Asymptotic covariance (p, p) of an M-estimate c (p,): E psi^2/(E psi')^2 times that of least squares.

    scale (k,) is the spread of the residuals of each equation.
    """
    residuals = rows.residuals(c) / scale
    slope, square = loss.moments(residuals)
    solution = factors.solve(rows.factor(1.0 / scale**2))
    factor = square / max(slope, 1e-3) ** 2 * residuals.size / max(residuals.size - solution.rank, 1)
    return solution.covariance * factor


@method("huber", "robust regression: Huber's M-estimator", RegressionMethod)
def Huber(
    rows: RegressionRows,
    k: float = option(
        EFFICIENT,
        "residual, in standard deviations, from which the loss is linear; 1.345: 95 % efficiency on Gaussian noise",
        POSITIVE,
        Real(0.3, 3.0, log=True),
    ),
) -> Fit:
    """Regression with Huber's loss, by iteratively reweighted least squares.

    The loss is convex, so the estimate is unique.  An outlier keeps the influence of a residual of k, so long bursts
    of outliers of one sign bias the estimate at any k; `tukey` and `lts` reject them.  The scale of each equation's
    residuals is 1.4826 times their median size, computed again in each iteration.  Huber 1964, Annals of Mathematical
    Statistics 35.
    """
    return m_estimate(rows, Loss("huber", k))


@method("tukey", "robust regression: Tukey's biweight, started from Huber's estimate", RegressionMethod)
def Tukey(
    rows: RegressionRows,
    k: float = option(
        4.685,
        "residual, in standard deviations, beyond which a row has no weight; 4.685 gives 95 % efficiency",
        POSITIVE,
        Real(2.5, 10.0, log=True),
    ),
) -> Fit:
    """Regression with Tukey's biweight, by iteratively reweighted least squares.

    The loss is not convex: the iteration starts from Huber's estimate and keeps the scale of the residuals found
    there.  Gross outliers have no weight at all.  Beaton & Tukey 1974, Technometrics 16.
    """
    return m_estimate(rows, Loss("tukey", k), start=huber_estimate(rows))


SAMPLE = 600
"""Samples that the random starts are tried on."""
TRIED, KEPT = 2, 3
"""Concentration steps of every random start, and how many starts are iterated to the end."""
CUT = 2.5
"""Scaled residual beyond which the final fit leaves out a row."""
MOST_STEPS = 30
"""Concentration steps at most."""


@method("lts", "robust regression: least trimmed squares (FAST-LTS), reweighted", RegressionMethod)
def Lts(
    rows: RegressionRows,
    coverage: float = option(
        0.75,
        "share h/n of rows",
        number("a number above 0.5 and up to 1", lambda value: 0.5 < value <= 1.0),
        Real(0.55, 1.0),
    ),
    starts: int = option(20, "random elemental starts, in addition to Huber's estimate", whole(0)),
    seed: int = option(0, "seed of the generator that draws them", whole(0)),
) -> Fit:
    """Least squares over the `coverage` share of rows that fit best, then over all rows within 2.5 standard deviations.

    Rousseeuw & Van Driessen 2006, Data Mining and Knowledge Discovery 12.  Rows are first divided by the spread of
    their equation's residuals under Huber's estimate.
    """
    huber = huber_estimate(rows)
    random = _random_starts(rows, huber, coverage, starts, np.random.default_rng(seed))
    found = [_concentrated(rows, huber.scale, c, coverage) for c in (huber.solution.x, *random)]
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
