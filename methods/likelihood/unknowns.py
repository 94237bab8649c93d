"""Published parameters as the unknowns of a fit: some held, some within bounds, some with a Gaussian prior."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from ...models.model import Model
    from ..ls import LeastSquares

STEP = 1e-6
"""Relative step of the derivative of coefficients with respect to published parameters."""


@dataclass(frozen=True)
class Unknowns:
    """The k published parameters that a fit moves, out of the q of a model.

    values (q,) holds the parameters that are kept (nan for those that move), low and high (q,) the bounds (infinite
    where there are none), mean and sd (q,) the prior (sd infinite where there is none).  The fit's unknowns are the
    published parameters themselves, so that a fixed K or a prior on T means what it says where the model's
    coefficients are K/T and -1/T.
    """

    model: Model
    values: np.ndarray
    low: np.ndarray
    high: np.ndarray
    mean: np.ndarray
    sd: np.ndarray

    @classmethod
    def all_of(cls, model: Model) -> Unknowns:
        """Every parameter free, without bounds and prior."""
        nothing = np.full(len(model.parameter_names), np.nan)
        wide = np.full(nothing.size, np.inf)
        return cls(model, nothing, -wide, wide, nothing, wide)

    @property
    def moving(self) -> np.ndarray:
        """Indices (k,) of the parameters that move."""
        return np.flatnonzero(np.isnan(self.values))

    @property
    def names(self) -> tuple[str, ...]:
        return tuple(self.model.parameter_names[i] for i in self.moving)

    @property
    def held(self) -> tuple[str, ...]:
        """Names of the parameters that are kept."""
        return tuple(self.model.parameter_names[i] for i in np.flatnonzero(np.isfinite(self.values)))

    @property
    def bounded(self) -> bool:
        return bool(np.isfinite(self.low).any() or np.isfinite(self.high).any())

    def holding(self, index: int, value: float) -> Unknowns:
        """The same with parameter `index` kept at `value`."""
        values = self.values.copy()
        values[index] = value
        return replace(self, values=values)

    def parameters(self, y: np.ndarray) -> np.ndarray:
        """All parameters (q,) from those that move (k,)."""
        full = self.values.copy()
        full[self.moving] = y
        return full

    def coefficients(self, y: np.ndarray) -> np.ndarray:
        """Coefficients (p,) of the model."""
        with np.errstate(all="ignore"):
            return self.model.from_parameters(self.parameters(y))

    def jacobian(self, y: np.ndarray) -> np.ndarray:
        """d coefficients / d moving parameters, (p, k)."""
        if not self.model.kernels.PUBLISHED:
            return np.eye(len(self.values))[:, self.moving]
        columns = [np.zeros((len(self.model.coordinates), 0))]
        for i, value in enumerate(y):
            step = STEP * max(abs(value), 1e-9)
            ends = [self.coefficients(np.where(np.arange(y.size) == i, value + side * step, y)) for side in (-1, 1)]
            columns.append((ends[1] - ends[0]) / (2.0 * step))
        return np.column_stack(columns)

    def prior_rows(self, y: np.ndarray) -> np.ndarray:
        """Rows (m, k + 1) of [derivatives | mean - value], in standard deviations of the prior."""
        place = np.isfinite(self.sd[self.moving])
        mean, sd = self.mean[self.moving][place], self.sd[self.moving][place]
        return np.column_stack([np.eye(y.size)[place] / sd[:, None], (mean - y[place]) / sd])

    def prior_cost(self) -> float:
        """Negative log prior of the parameters that are kept."""
        kept = np.isfinite(self.values) & np.isfinite(self.sd)
        return float(0.5 * np.sum(((self.values[kept] - self.mean[kept]) / self.sd[kept]) ** 2))

    def inside(self, y: np.ndarray) -> np.ndarray:
        """y (k,) moved into the bounds."""
        return np.clip(y, self.low[self.moving], self.high[self.moving])

    def covariance(self, y: np.ndarray, covariance: np.ndarray) -> np.ndarray:
        """Covariance (p, p) of the coefficients from that (k, k) of the moving parameters (infinite: undetermined)."""
        jacobian = self.jacobian(y)
        unknown = ~np.isfinite(np.diag(covariance))
        finite = np.where(unknown[:, None] | unknown[None, :], 0.0, covariance)
        found = jacobian @ finite @ jacobian.T
        told = (np.abs(jacobian) * unknown).sum(axis=1) == 0.0
        found[~told, ~told] = np.inf
        return found

    def start(self, coefficients: np.ndarray, source: LeastSquares | None = None) -> np.ndarray | None:
        """Moving parameters (k,) to start from: the least-squares solution `source` under prior and fixed values.

        Linearised about `coefficients` (p,).  None where the coefficients have no published parameters near.
        """
        full = self._published(coefficients)
        if full is None:
            return None
        if source is None:
            return self.inside(full[self.moving])
        jacobian = Unknowns.all_of(self.model).jacobian(full)
        rows = np.linalg.pinv(source.half)
        left, right = rows @ jacobian, rows @ (source.coefficients - self.model.from_parameters(full))
        moved = np.where(np.isnan(self.values), 0.0, self.values - full)
        prior = self.prior_rows(full[self.moving])
        a = np.vstack([left[:, self.moving], prior[:, :-1]])
        b = np.concatenate([right - left @ moved, prior[:, -1]])
        length = np.linalg.norm(a, axis=0)
        length = np.where(length > 0.0, length, 1.0)
        y = full[self.moving] + np.linalg.lstsq(a / length, b, rcond=1e-12)[0] / length
        return self.inside(y) if np.isfinite(y).all() else None

    def _published(self, coefficients: np.ndarray) -> np.ndarray | None:
        """Parameters (q,) of the coefficients, or of ones with a coefficient changed until they are real."""
        for factor in (1.0, *(1.3**k for k in (1, -1, 2, -2, 4, -4, 8, -8, 12, -12))):
            for i in range(len(coefficients) if factor != 1.0 else 1):
                tried = coefficients.copy()
                tried[i] *= factor
                full = self.model.to_parameters(tried)
                if np.isfinite(full).all():
                    return full
        return None
