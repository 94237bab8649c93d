"""Unscented Kalman filter of one record, for joint state and parameter estimation (`joint`).

The joint density goes through one RK4 sample step at sigma points instead of along the tangent, so no sensitivities
are needed.  Sources: Julier & Uhlmann 1997; Wan & van der Merwe 2000 (scaled form).
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from ...records.series import Series
from .joint import CoefficientDensity, FilteredRecord, NoiseVariances, grid_points, joint_start

if TYPE_CHECKING:
    from ....models.model import Model


@dataclass(frozen=True)
class Unscented:
    """The filter, as a `joint.RecordFilter`.

    alpha is the distance of the sigma points in units of sqrt(m) standard deviations, m being the size of the joint
    vector; beta the weight of the mean's shift in the covariance (2 for Gaussian densities).
    """

    alpha: float = 0.1
    beta: float = 2.0

    def __call__(
        self, model: Model, series: Series, density: CoefficientDensity, noise: NoiseVariances
    ) -> FilteredRecord:
        """One record through the filter, from its initial state and a density of the coefficients."""
        from ....models.simulate import substeps
        from . import _unscented_kernels

        n, p = len(model.states), len(model.coordinates)
        z, covariance = joint_start(model, series, density)
        theta = np.concatenate([density.coefficients, model.constants])
        path, innovations = np.empty((len(series.outputs), p)), np.empty_like(series.outputs)
        cost = _unscented_kernels.unscented(
            model.kernels.rhs, z, theta, covariance, density.origin, np.ascontiguousarray(density.factor),
            series.inputs, series.outputs, grid_points(series), series.columns,
            series.dt, substeps(model, series.dt), noise.process, noise.sensor[series.columns], self.alpha, self.beta,
            path, innovations,
        )  # fmt: skip
        after = density._replace(mean=z[n:], covariance=covariance[n:, n:])
        return FilteredRecord(after, path, innovations, cost if np.isfinite(z).all() else np.inf)
