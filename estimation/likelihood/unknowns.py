"""Published parameters as the unknowns of a fit: some fixed, some within bounds, some with a Gaussian prior."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from ...models.linear_algebra import lstsq, pinv
from ...models.model import Model
from ..numerics import factors
from ..regression.least_squares import LeastSquares

STEP = 1e-6
"""Relative step of the derivative of coefficients with respect to published parameters."""


@dataclass(frozen=True)
class Unknowns:
    """The k published parameters that a fit estimates, out of the q of a model.

    values (q,) holds the fixed parameters (nan for those that are estimated), low and high (q,) the bounds (infinite
    where there are none), mean and sd (q,) the prior (sd infinite where there is none).  The unknowns of the fit are
    the published parameters themselves, so that one can fix K or give a prior of T where the model's coefficients are
    K/T and -1/T.
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
    def estimated(self) -> np.ndarray:
        """Indices (k,) of the estimated parameters."""
        return np.flatnonzero(np.isnan(self.values))

    @property
    def names(self) -> tuple[str, ...]:
        """Names (k) of the estimated parameters."""
        return tuple(self.model.parameter_names[i] for i in self.estimated)

    @property
    def fixed_names(self) -> tuple[str, ...]:
        """Names of the fixed parameters."""
        return tuple(self.model.parameter_names[i] for i in np.flatnonzero(np.isfinite(self.values)))

    @property
    def has_bounds(self) -> bool:
        """Whether any parameter has a bound."""
        return bool(np.isfinite(self.low).any() or np.isfinite(self.high).any())

    def with_fixed(self, index: int, value: float) -> Unknowns:
        """The same with parameter `index` fixed at `value`."""
        values = self.values.copy()
        values[index] = value
        return replace(self, values=values)

    def parameters(self, y: np.ndarray) -> np.ndarray:
        """All parameters (q,) from the estimated ones (k,)."""
        full = self.values.copy()
        full[self.estimated] = y
        return full

    def coefficients(self, y: np.ndarray) -> np.ndarray:
        """Coefficients (p,) of the model."""
        with np.errstate(all="ignore"):
            return self.model.from_parameters(self.parameters(y))

    def jacobian(self, y: np.ndarray) -> np.ndarray:
        """d coefficients / d estimated parameters, (p, k)."""
        if not self.model.kernels.PUBLISHED:
            return np.eye(len(self.values))[:, self.estimated]
        columns = [np.zeros((len(self.model.coordinates), 0))]
        for i, value in enumerate(y):
            step = STEP * max(abs(value), 1e-9)
            ends = [self.coefficients(np.where(np.arange(y.size) == i, value + side * step, y)) for side in (-1, 1)]
            columns.append((ends[1] - ends[0]) / (2.0 * step))
        return np.column_stack(columns)

    def prior_rows(self, y: np.ndarray) -> np.ndarray:
        """Rows (m, k + 1) of [derivatives | mean - value], in standard deviations of the prior."""
        place = np.isfinite(self.sd[self.estimated])
        mean, sd = self.mean[self.estimated][place], self.sd[self.estimated][place]
        return np.column_stack([np.eye(y.size)[place] / sd[:, None], (mean - y[place]) / sd])

    def prior_cost(self) -> float:
        """Negative log prior of the fixed parameters."""
        fixed = np.isfinite(self.values) & np.isfinite(self.sd)
        return float(0.5 * np.sum(((self.values[fixed] - self.mean[fixed]) / self.sd[fixed]) ** 2))

    def clipped(self, y: np.ndarray) -> np.ndarray:
        """y (k,) with values outside the bounds set on them."""
        return np.clip(y, self.low[self.estimated], self.high[self.estimated])

    def start(self, coefficients: np.ndarray, source: LeastSquares | None = None) -> np.ndarray | None:
        """Estimated parameters (k,) to start from: the least-squares solution `source` with prior and fixed values.

        Linearised about `coefficients` (p,).  None where no real published parameters are near the coefficients.
        """
        full = self._published(coefficients)
        if full is None:
            return None
        if source is None:
            return self.clipped(full[self.estimated])
        jacobian = Unknowns.all_of(self.model).jacobian(full)
        rows = pinv(source.half)
        left, right = rows @ jacobian, rows @ (source.coefficients - self.model.from_parameters(full))
        shift = np.where(np.isnan(self.values), 0.0, self.values - full)
        prior = self.prior_rows(full[self.estimated])
        a = np.vstack([left[:, self.estimated], prior[:, :-1]])
        b = np.concatenate([right - left @ shift, prior[:, -1]])
        length = factors.column_lengths(a)
        y = full[self.estimated] + lstsq(a / length, b, rcond=1e-12) / length
        return self.clipped(y) if np.isfinite(y).all() else None

    def _published(self, coefficients: np.ndarray) -> np.ndarray | None:
        """Parameters (q,) of the coefficients, one of which is changed until they are real; None if that fails."""
        for factor in (1.0, *(1.3**k for k in (1, -1, 2, -2, 4, -4, 8, -8, 12, -12))):
            for i in range(len(coefficients) if factor != 1.0 else 1):
                tried = coefficients.copy()
                tried[i] *= factor
                full = self.model.to_parameters(tried)
                if np.isfinite(full).all():
                    return full
        return None
