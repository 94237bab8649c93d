"""Least squares on records that are filtered or smoothed first, without a lag between channels."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ..datasets.record import Record
from ..estimation.methods_only.regression.smoothed import smoothed_rows
from ..estimation.methods_only.tuning.space import Integer, Real
from ..estimation.numerics import factors
from ..estimation.observers.smoothing import averaging_length
from ..estimation.regression.filtered import ORDER, row_factors
from ..estimation.regression.filtered_fit import CORNERS, FilteredFit, best_corner, coloured_covariance, fit_filtered
from ..estimation.regression.least_squares import least_squares
from ..estimation.results.fit import Fit
from ..models.model import Model
from .base import Method
from .options import POSITIVE, option, whole


class SvfLs(Method):
    """Least squares after a state-variable filter F(s) = omega^n/(s + omega)^n on every channel.

    Response models need yaw rate or heading, and use both where both are measured; 3-DOF models need surge, sway and
    one of them.

    Exact without noise at every corner frequency within the sampling rate.  Noise that the filter leaves in the
    regressors (of heading and rudder) biases the estimate, most where a pole and a zero nearly cancel: for `patrol`
    (T2 .32 s, T3 .18 s) by 30 and 48 % at low noise, and at no corner frequency by less; `iv` and `output-error` have
    no such bias.
    """

    name = "svf-ls"
    title = "least squares on state-variable filtered records"
    omega: float | None = option(
        None,
        "corner frequency, rad/s; None takes the one of 11 whose free run follows the training records best",
        POSITIVE,
        Real(1e-2, 30.0, log=True),
    )
    order: int = option(
        ORDER,
        "number n of poles of the filter; at least the order of the highest derivative (3 for heading records and "
        "second-order response models)",
        whole(3),
        Integer(3, 6),
    )

    def estimate(self, records: Sequence[Record], model: Model) -> Fit:
        if self.omega is None:
            found = best_corner(records, model, self.order)
        else:
            found = fit_filtered(records, model, self.omega, self.order)
        solution = found.solution
        return Fit(
            solution.coefficients,
            coloured_covariance(found, model),
            converged=not np.isposinf(found.cost),
            message=factors.rank_message(solution.rank, len(model.coordinates)),
            n_iterations=CORNERS if self.omega is None else 1,
            extra={"omega_rad_s": found.omega, "rank": solution.rank, "condition": solution.condition},
        )


class RtsLs(Method):
    """Records smoothed by a kinematic model, then least squares on the states and accelerations.

    Surge, sway and yaw are each an integrated random walk, whose order and process noise have the largest likelihood
    for all records; heading and yaw rate are smoothed as one motion.  The smoother (Rauch-Tung-Striebel) has no lag,
    but it rounds off fast changes; the rudder passes through yaw's smoother too, so a linear equation of yaw stays
    exact.

    3-DOF models need surge, sway and yaw rate or heading, response models yaw rate or heading.
    """

    name = "rts-ls"
    title = "least squares on states and accelerations smoothed by a kinematic model (RTS)"
    level: float = option(
        1.0,
        "factor on the process noise: below 1 smooths more than the likelihood suggests",
        POSITIVE,
        Real(1e-3, 1e3, log=True),
    )

    def estimate(self, records: Sequence[Record], model: Model) -> Fit:
        rows, walks, dt = smoothed_rows(records, model, self.level)
        found = least_squares(*row_factors(rows, model))
        slowest = max(averaging_length(walk) for walk in walks.values()) * dt
        return Fit(
            found.coefficients,
            coloured_covariance(FilteredFit(1.0 / slowest, rows, found, np.nan), model),
            message=factors.rank_message(found.rank, len(model.coordinates)),
            extra={"rank": found.rank, "walks": {s: {"order": w.order, "level": w.level} for s, w in walks.items()}},
        )
