"""Score tests with nuisance projected out, and their family-wise level by multiplier draws."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..methods.innovations.estimator import CLIP, Innovations

DRAWS = 2000
TIE_NATS, MOST_TIED = 4.6, 2
"""Log p-values within which significant rivals are tied, and how many are told beside the best."""


def log_tail(statistic: float, k: int) -> float:
    """log P(chi2_k > statistic), also far in the tail."""
    from scipy.special import gammaln
    from scipy.stats import chi2

    x = max(float(statistic), 1e-9)
    if x < 300.0:
        return float(chi2.logsf(x, k))
    return float(-0.5 * x + (0.5 * k - 1.0) * np.log(0.5 * x) - gammaln(0.5 * k))


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

    prior : (m,) precisions of the nuisance parameters, None for none.
    """

    def __init__(self, now: Innovations, nuisance: np.ndarray, prior: np.ndarray | None = None) -> None:
        self.residual = np.clip(now.e, -CLIP, CLIP).ravel()
        self.nuisance = nuisance
        information = nuisance @ nuisance.T
        fisher = information + (np.diag(prior) if prior is not None else 0.0)
        scale = np.sqrt(np.diag(fisher)) + 1e-300
        outer = np.outer(scale, scale)
        self.inverse = np.linalg.pinv(fisher / outer, rcond=1e-11, hermitian=True) / outer if len(nuisance) else fisher
        self.lost = 2.0 * self.inverse - self.inverse @ information @ self.inverse

    def project(self, columns: np.ndarray) -> np.ndarray:
        """Columns (m, n) or one (n,) less their regression on the nuisance."""
        if not len(self.nuisance):
            return columns
        return columns - (columns @ self.nuisance.T) @ self.inverse @ self.nuisance

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
        told = np.diag(information) > 1e-12 * whole
        scale = np.where(told, np.sqrt(np.maximum(np.diag(information), 1e-300)), np.inf)
        share = float(np.max(np.diag(information) / np.maximum(whole, 1e-300)))
        if not np.isfinite(information).all() or share <= 0.0:
            return Score(0.0, np.zeros(len(columns)), 0.0, np.zeros((len(columns),) * 2))
        gradient = -(left @ self.residual) / scale
        matrix = information / np.outer(scale, scale) + np.diag(np.where(told, 1e-10, 1.0))
        step = np.linalg.solve(matrix, gradient)
        return Score(float(gradient @ step), step / scale, share, information)


def effective_number(
    projector: Projector, families: list[list[np.ndarray]], rng: np.random.Generator, level: float = 0.05
) -> float:
    """How many independent tests the bank amounts to, from DRAWS multiplier draws of all its scores.

    families : for each cause the columns (k, n) of its variants; a cause's p-value counts its variants.
    The smallest p-value of the null bank is below p in a share 1 - (1 - p)^n_eff of the draws.
    """
    from scipy.stats import chi2

    flat = [columns for variants in families for columns in variants]
    owners = np.repeat(np.arange(len(families)), [len(v) for v in families])
    left = [projector.project(columns) for columns in flat]
    n = projector.residual.size // 6
    blocks = np.arange(projector.residual.size) // 6
    stacked = np.vstack(left) * projector.residual
    summed = np.add.reduceat(stacked, np.searchsorted(blocks, np.arange(n)), axis=1)
    draws = rng.standard_normal((DRAWS, n)).astype(np.float32) @ summed.T.astype(np.float32)
    smallest = np.ones(DRAWS)
    at = 0
    for owner, columns in zip(owners, left, strict=True):
        k = len(columns)
        part = draws[:, at : at + k].astype(float)
        part_sum = summed[at : at + k]
        at += k
        spread = part_sum @ part_sum.T
        scale = np.where(np.diag(spread) > 0.0, np.sqrt(np.maximum(np.diag(spread), 1e-300)), np.inf)
        inverse = np.linalg.pinv(spread / np.outer(scale, scale), rcond=1e-9, hermitian=True)
        z = part / scale
        p = chi2.sf(np.einsum("ij,jk,ik->i", z, inverse, z), k) * len(families[owner])
        smallest = np.minimum(smallest, p)
    threshold = float(np.quantile(smallest, level))
    return float(np.clip(np.log1p(-level) / np.log1p(-min(threshold, 0.5)), 1.0, 1000.0))


def independent(rng: np.random.Generator, columns: np.ndarray, residual: np.ndarray, draws: int = 500) -> float:
    """How many independent tests of one parameter the projected columns (m, n) amount to, by multiplier draws."""
    from scipy.stats import chi2

    if not len(columns):
        return 1.0
    summed = (columns * residual).reshape(len(columns), -1, 6).sum(axis=2).astype(np.float32)
    scale = np.sqrt(np.sum(summed**2, axis=1)) + 1e-30
    normal = rng.standard_normal((draws, summed.shape[1]), dtype=np.float32)
    largest = np.max((normal @ summed.T / scale) ** 2, axis=1)
    p = float(chi2.sf(np.quantile(largest, 0.9), 1))
    return float(np.clip(np.log1p(-0.1) / np.log1p(-min(p, 0.5)), 1.0, len(columns)))


def canonical_correlation(projector: Projector, first: np.ndarray, second: np.ndarray) -> float:
    """Largest canonical correlation of the projected columns of two causes."""
    a, b = (np.linalg.qr(projector.project(c).T)[0] for c in (first, second))
    return float(np.linalg.svd(a.T @ b, compute_uv=False)[0])
