"""Score tests with nuisance projected out, and their levels.

A change time, a time constant or a frequency means nothing while the effect's size is zero, and a delay, a play or a
variance cannot be negative: the likelihood-ratio statistic is then not chi2.  It is compared with the largest score
over the values that are searched, drawn by multiplier bootstrap (Hansen 1996) around the present setting, the recorded
rudder used again.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from ...checks.tails import chi2_tail, normal_tail
from ...estimation.filters.innovations.estimator import Innovations
from ...estimation.filters.innovations.noise_fit import CLIP
from ...estimation.filters.innovations.vector import CHANNELS
from ...models.linear_algebra import finite, information_inverse, pinv, svd

if TYPE_CHECKING:
    from ...estimation.filters.innovations.settings import Setting
    from .state import Point


DRAWS = 5000


@dataclass(frozen=True)
class Score:
    """An efficient score test of k parameters: statistic, estimate of one step (k,), and the share of the
    information that is left after the nuisance was projected out (0: in its span)."""

    statistic: float
    step: np.ndarray
    share: float
    information: np.ndarray


class Projector:
    """Innovations and columns with the columns of nuisance parameters projected out.

    residual : (N*6,) innovations, clipped.
    nuisance : (m, N*6) columns.
    prior : (m,) precisions of the nuisance parameters, None for none.
    """

    def __init__(self, now: Innovations, nuisance: np.ndarray, prior: np.ndarray | None = None) -> None:
        self.residual = np.clip(now.e, -CLIP, CLIP).ravel()
        information = nuisance @ nuisance.T
        if not np.isfinite(information).all():  # too large to be squared: such columns are left out
            nuisance = np.where(np.isfinite(np.diag(information))[:, None], nuisance, 0.0)
            information = np.nan_to_num(nuisance @ nuisance.T)
        self.nuisance = nuisance
        fisher = information + (np.diag(prior) if prior is not None else 0.0)
        self.inverse = information_inverse(fisher, 1e-11) if len(nuisance) else fisher
        self.lost = 2.0 * self.inverse - self.inverse @ information @ self.inverse

    def with_residual(self, now: Innovations) -> Projector:
        """The same projection of other innovations, not clipped."""
        other = object.__new__(Projector)
        other.__dict__ = {**self.__dict__, "residual": now.e.ravel()}
        return other

    def project(self, columns: np.ndarray) -> np.ndarray:
        """Columns (m, n) or one (n,) less their regression on the nuisance."""
        if not len(self.nuisance):
            return columns
        return columns - (columns @ self.nuisance.T) @ self.inverse @ self.nuisance

    def terms(self, left: np.ndarray) -> np.ndarray:
        """What each sample adds (m, N) to the scores of projected columns (m, n)."""
        rows = left.reshape(len(left), -1, CHANNELS)
        scores = np.einsum("mnc,nc->mn", rows, self.residual.reshape(-1, CHANNELS))
        return np.negative(scores, out=scores)

    def products(self, columns: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Inner products (..., k, k) of projected columns (..., k, n), and (..., k) of those with the residual, without
        holding the projected columns."""
        along = columns @ self.nuisance.T
        inner = columns @ columns.swapaxes(-1, -2) - along @ self.lost @ along.swapaxes(-1, -2)
        return inner, columns @ self.project(self.residual)

    def score(self, columns: np.ndarray) -> Score:
        """Test that the parameters of columns (k, n) are zero."""
        left = self.project(columns)
        whole = np.einsum("ij,ij->i", columns, columns)
        information = left @ columns.T
        information = 0.5 * (information + information.T)
        kept = np.diag(information) > 1e-12 * whole
        scale = np.where(kept, np.sqrt(np.maximum(np.diag(information), 1e-300)), np.inf)
        share = float(np.max(np.diag(information) / np.maximum(whole, 1e-300)))
        if not np.isfinite(information).all() or share <= 0.0:
            return Score(0.0, np.zeros(len(columns)), 0.0, np.zeros((len(columns),) * 2))
        gradient = -(left @ self.residual) / scale
        matrix = information / np.outer(scale, scale) + np.diag(np.where(kept, 1e-10, 1.0))
        step = np.linalg.solve(matrix, gradient)
        return Score(float(gradient @ step), step / scale, share, information)


def effective_number(
    projector: Projector, families: list[list[np.ndarray]], rng: np.random.Generator, level: float = 0.05
) -> float:
    """How many independent tests the bank amounts to, from DRAWS multiplier draws of all its scores.

    families : for each cause the columns (k, n) of its variants; a cause's p-value counts its variants.
    The smallest p-value of the null bank is below p in a share 1 - (1 - p)^n_eff of the draws.
    """
    flat = [(columns, len(variants)) for variants in families for columns in variants]
    correlation = correlations(np.vstack([projector.terms(projector.project(columns)) for columns, _ in flat]))
    draws = normal_draws(rng, correlation)
    largest: dict[tuple[int, int], np.ndarray] = {}
    at = 0
    for columns, variants in flat:
        k = len(columns)
        inverse = pinv(correlation[at : at + k, at : at + k], rcond=1e-9, hermitian=True)
        own = draws[:, at : at + k]
        at += k
        statistic = np.einsum("ij,ij->i", own @ inverse, own)
        largest[k, variants] = np.maximum(largest.get((k, variants), 0.0), statistic)
    smallest = np.min([chi2_tail(x, k) * variants for (k, variants), x in largest.items()], axis=0)
    return float(np.clip(_tests(float(np.quantile(smallest, level)), level), 1.0, 1000.0))


def independent_tests(rng: np.random.Generator, terms: np.ndarray, sided: bool = False, level: float = 0.02) -> float:
    """How many independent tests of one parameter (chi2, one degree of freedom) the largest of several scores amounts
    to, from DRAWS multiplier draws.

    terms : (m, N) what each sample adds to each score.
    sided : the parameter cannot be negative, so that only positive scores count: one score is half a test.
    """
    correlation = correlations(terms)
    kept = np.diag(correlation) > 0.0
    correlation = correlation[np.ix_(kept, kept)]
    sides = 1.0 if sided else 2.0
    if not len(correlation):
        return 0.5 * sides
    draws = normal_draws(rng, correlation)
    largest = np.max(draws if sided else np.abs(draws), axis=1)
    p = sides * normal_tail(float(np.quantile(largest, 1.0 - level)))
    return 0.5 * sides * float(np.clip(_tests(p, level), 1.0, len(correlation)))


def _tests(p: float, level: float) -> float:
    """Number of independent tests of which the smallest p-value is below p in a share `level` of the cases."""
    return float(np.log1p(-level) / np.log1p(-min(p, 0.5)))


def correlations(terms: np.ndarray) -> np.ndarray:
    """Correlations (m, m) of sums of the terms (m, N) with random multipliers; those of empty ones, and of those that
    are not finite, are zero."""
    covariance = terms @ terms.T
    if not np.isfinite(covariance).all():
        largest = np.max(np.abs(terms), axis=1, keepdims=True)
        usable = np.isfinite(largest) & (largest > 0.0)
        terms = np.where(usable, terms, 0.0) / np.where(usable, largest, 1.0)
        covariance = terms @ terms.T
    spread = np.sqrt(np.diag(covariance))
    scale = np.where(spread > 0.0, spread, np.inf)
    return covariance / np.outer(scale, scale)


def normal_draws(rng: np.random.Generator, correlation: np.ndarray) -> np.ndarray:
    """DRAWS standard normal vectors of given correlations: what normal multipliers of all samples would sum to."""
    value, axes = np.linalg.eigh(finite(correlation))
    return rng.standard_normal((DRAWS, len(value))) @ (axes * np.sqrt(np.maximum(value, 0.0))).T


def cauchy_combination(log_p: Sequence[float]) -> float:
    """Log p-value of several tests combined, valid under arbitrary dependence (Liu and Xie 2020)."""
    smallest, n = min(log_p), len(log_p)
    if smallest < -30.0:
        return smallest + float(np.log(n))
    p = np.clip(np.exp(log_p), 0.0, 1.0 - 1e-9)
    return float(np.log(0.5 - np.arctan(np.mean(np.tan(np.pi * (0.5 - p)))) / np.pi))


def canonical_correlation(projector: Projector, first: np.ndarray, second: np.ndarray) -> float:
    """Largest canonical correlation of the projected columns of two causes."""
    a, b = (np.linalg.qr(finite(projector.project(c).T))[0] for c in (first, second))
    return float(svd(a.T @ b, compute_uv=False)[0])


ONE_SIDED = 0.5
"""How many tests a single score is whose parameter cannot be negative."""
NUDGE = 0.01
"""Share by which noise is changed for the scores of noise."""
TESTABLE = 1e-3
"""Share of a score's information that must survive the nuisance."""


def largest_score(rng: np.random.Generator, projector: Projector, columns: np.ndarray) -> tuple[int, Score, float]:
    """The column (m, n) of largest score, and how many independent tests the choice among them amounts to."""
    scores = [projector.score(column[None]) for column in columns]
    best = int(np.argmax([score.statistic for score in scores]))
    return best, scores[best], independent_tests(rng, projector.terms(projector.project(columns)))


def independent_values(rng: np.random.Generator, point: Point, runs: Sequence[Innovations]) -> float:
    """How many tests of one parameter the choice among its values amounts to, all to one side of zero.

    runs : innovations at the present setting with the effect at each of the values.
    """
    changes = [point.now.change(run).ravel() for run in runs if not run.diverged]
    if not changes:
        return ONE_SIDED
    projector = point.projector
    return independent_tests(rng, projector.terms(projector.project(np.stack(changes))), sided=True)


def independent_variances(
    rng: np.random.Generator, point: Point, settings: Sequence[Setting]
) -> tuple[float, list[float]]:
    """How many tests of one variance the choice among its kinds amounts to, in all segments and in each.

    settings : the present one with a little noise of each kind; that of sensors and gusts is projected out.
    """
    est, noise = point.est, point.setting.noise
    nuisance = []
    for c in np.flatnonzero(est.channels):
        nuisance.append(replace(noise, sensor_sd=_nudged(noise.sensor_sd, int(c))))
    for j in np.flatnonzero(noise.force_sd):
        nuisance.append(replace(noise, force_sd=_nudged(noise.force_sd, int(j))))
    varied = [replace(point.setting, noise=n) for n in nuisance]
    terms = np.stack([_of_variance(point.now, run) for run in est.many([*varied, *settings])])

    def tests(terms: np.ndarray) -> float:
        fixed, own = terms[: len(nuisance)], terms[len(nuisance) :]
        left = own - own @ pinv(fixed) @ fixed
        kept = np.sum(left**2, axis=1) > TESTABLE * np.sum(own**2, axis=1)
        return independent_tests(rng, left[kept], sided=True)

    return tests(terms), [tests(part) for part in np.split(terms, est.edges[1:-1], axis=1)]


def _nudged(sd: np.ndarray, j: int) -> np.ndarray:
    changed = sd.copy()
    changed[j] *= 1.0 + NUDGE
    return changed


def _of_variance(now: Innovations, run: Innovations) -> np.ndarray:
    """What each sample adds (N,) to the score of a little noise."""
    e = np.clip(now.e, -CLIP, CLIP)
    return np.sum((e**2 - 1.0) * (run.log_s - now.log_s) - e * now.change(run), axis=1)
