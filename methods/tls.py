"""Total least squares: errors in the regressors as well as on the left side."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, ClassVar, NamedTuple

import numpy as np

from ..models.errors import BadInput
from . import factors
from .base import Fit, FitFailed, Method
from .ls import check_scheme
from .regression import Differences, differences
from .tuning.space import Choice
from .weighted import Regression

if TYPE_CHECKING:
    from ..datasets.record import Record
    from ..models.model import Model

SCALINGS = ("noise", "unit")
EXACT = 1e-4
"""Share of noise in a column's root mean square below which the column counts as exact."""


class Total(NamedTuple):
    """A total least-squares solution of one equation."""

    x: np.ndarray
    covariance: np.ndarray
    gap: float
    """Smallest singular value over that of the regressors alone: near 1 the solution is not unique."""


class Tls(Method):
    """Scaled total least squares by singular values, mixed with ordinary least squares for exact columns.

    Parameters
    ----------
    scaling : 'noise' (each column in units of its own white noise, read off its third differences; columns without
        visible noise, such as the rudder's, are exact) or 'unit' (all columns of unit length, none exact).
    scheme : difference scheme, see `regression`.

    Golub & Van Loan 1980; exact columns as in Van Huffel & Vandewalle 1991, section 3.5.  The equations of a 3-DOF
    model are solved one by one where they share no coefficient.  With nearly collinear regressors the solution is
    wild (`extra['gap']` near 1), which is what the method does and not a failure.
    """

    name = "tls"
    title = "scaled total least squares (SVD)"
    search_space: ClassVar = {"scaling": Choice("noise", "unit"), "scheme": Choice("forward", "midpoint")}

    def __init__(self, scaling: str = "noise", scheme: str = "midpoint") -> None:
        self.scaling, self.scheme = scaling, scheme

    def check_options(self) -> None:
        super().check_options()
        check_scheme(self.scheme)
        if self.scaling not in SCALINGS:
            raise BadInput(f"scaling is {self.scaling!r}", hint=f"known: {', '.join(SCALINGS)}")

    def estimate(self, records: Sequence[Record], model: Model) -> Fit:
        parts = differences(records, model, self.scheme)
        rows = Regression(parts, model)
        c, covariance, gaps = np.zeros(rows.p), np.diag(np.full(rows.p, np.inf)), []
        for group in _groups(rows):
            weight = np.zeros(rows.used.size)
            weight[group] = 1.0 / np.maximum(rows.start.residual_sd[rows.used][group], 1e-13 * rows.left[group]) ** 2
            factor = rows.factor(weight)
            columns = np.flatnonzero(np.any(factor[:, :-1] != 0.0, axis=0))
            noise = _noise(parts, rows, group, columns) if self.scaling == "noise" else None
            found = total(np.column_stack([factor[:, columns], factor[:, -1]]), rows.n * len(group), noise)
            c[columns] = found.x
            covariance[np.ix_(columns, columns)] = found.covariance
            gaps.append(found.gap)
        if not np.isfinite(c).all():
            raise FitFailed("total least squares has no finite solution")
        return Fit(c, covariance, extra={"gap": gaps})


def _groups(rows: Regression) -> list[list[int]]:
    """Equations (indices into `rows.used`) that share coefficients, together."""
    uses = [set(np.flatnonzero(np.any(rows.equations[e][:, :-1] != 0.0, axis=0)).tolist()) for e in rows.used]
    groups: list[tuple[list[int], set[int]]] = []
    for e, own in enumerate(uses):
        shared = [group for group in groups if group[1] & own]
        members = [e, *(i for group in shared for i in group[0])]
        groups = [group for group in groups if not group[1] & own]
        groups.append((sorted(members), own.union(*(group[1] for group in shared))))
    return [members for members, _ in groups]


def _noise(parts: Sequence[Differences], rows: Regression, group: list[int], columns: np.ndarray) -> np.ndarray:
    """White noise (m + 1,) of the columns and the left side of a group's weighted rows; 0 where it is invisible."""
    weight = 1.0 / np.maximum(rows.start.residual_sd[rows.used][group], 1e-13 * rows.left[group])
    third, square, n, jumps = 0.0, 0.0, 0, 0
    for _, y, phi in rows.blocks():
        for e, w in zip(group, weight, strict=True):
            table = w * np.column_stack([phi[:, e][:, columns], y[:, e]])
            bent = np.diff(table, 3, axis=0)
            third, square = third + _trimmed(bent), square + (table**2).sum(axis=0)
            n, jumps = n + len(table), jumps + len(bent)
    sd = np.sqrt(third / max(jumps, 1) / 20.0)
    rms = np.sqrt(square / n)
    sd = np.where(sd > EXACT * rms, sd, 0.0)
    sd[-1] = max(sd[-1], EXACT * rms[-1])
    return sd


def _trimmed(bent: np.ndarray) -> np.ndarray:
    """Sum of squares (m,) of third differences, from their median size so that kinks do not count."""
    if not len(bent):
        return np.zeros(bent.shape[1])
    return len(bent) * (1.4826 * np.median(np.abs(bent), axis=0)) ** 2


def total(factor: np.ndarray, n: int, noise: np.ndarray | None = None) -> Total:
    """Total least squares of [A | b] given by a triangular factor of its n rows.

    Parameters
    ----------
    noise : (m + 1,) standard deviation of the errors in each column of [A | b]; zero: exact.  None: proportional to
        the columns' lengths.

    Exact columns are eliminated by orthogonal decomposition; of what is left, in units of the noise, the right
    singular vector of the smallest singular value is (x, -1).
    """
    m = factor.shape[1] - 1
    length = np.linalg.norm(factor, axis=0)
    length = np.where(length > 0.0, length, 1.0)
    noise = length if noise is None else noise
    exact, noisy = np.flatnonzero(noise[:m] == 0.0), np.flatnonzero(noise[:m] > 0.0)
    order = np.concatenate([exact, noisy, [m]])
    unit = np.where(noise > 0.0, noise, length)
    triangle = np.asarray(np.linalg.qr(factor[:, order] / unit[order], mode="r"), float)
    rest = triangle[exact.size :, exact.size :]
    _, s, vt = np.linalg.svd(rest, full_matrices=True)
    vector = vt[-1]
    if abs(vector[-1]) < 1e-14:
        raise FitFailed("total least squares has no solution: the regressors are dependent within their noise")
    x = np.zeros(m)
    x[noisy] = -vector[:-1] / vector[-1]
    right = triangle[: exact.size, -1] - triangle[: exact.size, exact.size : -1] @ x[noisy]
    if exact.size:
        x[exact] = factors.solve(np.column_stack([triangle[: exact.size, : exact.size], right])).x
    least = float(s[-1]) if len(s) == rest.shape[1] else 0.0
    alone = np.linalg.svd(rest[:, :-1], compute_uv=False)[-1] if noisy.size else np.inf
    covariance = _covariance(triangle, exact.size, float((x[noisy] ** 2).sum()), least, n)
    back = np.empty(m)
    back[order[:-1]] = unit[m] / unit[order[:-1]]
    inverse = np.argsort(order[:-1])
    return Total(x * back, covariance[np.ix_(inverse, inverse)] * np.outer(back, back), least / float(alone))


def _covariance(triangle: np.ndarray, exact: int, size: float, least: float, n: int) -> np.ndarray:
    """First-order covariance in scaled columns: s^2 (1 + |x|^2) (A'A - n s^2 I)^-1 with s^2 the noise found.

    The identity and `size`, |x|^2, only count columns after the first `exact` ones.
    """
    m = triangle.shape[1] - 1
    variance = least**2 / max(n - m, 1)
    _, s, vt = np.linalg.svd(triangle[:, :-1], full_matrices=False)
    middle = (vt.T * s**2) @ vt - np.diag(n * variance * (np.arange(m) >= exact))
    values, vectors = np.linalg.eigh((middle + middle.T) / 2.0)
    values = np.maximum(values, 1e-14 * s[0] ** 2)
    return variance * (1.0 + size) * (vectors / values) @ vectors.T
