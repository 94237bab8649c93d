"""Least squares on state-variable filtered records: no lag between channels, unlike paper 003's observer."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, ClassVar

import numpy as np

from ..estimation.methods_only.tuning.space import Integer, Real
from ..estimation.numerics import factors
from ..estimation.regression.filtered import ORDER
from ..estimation.regression.filtered_fit import CORNERS, best_corner, coloured_covariance, fit_filtered
from ..estimation.results.fit import Fit
from ..models.errors import BadInput
from .base import Method

if TYPE_CHECKING:
    from ..datasets.record import Record
    from ..models.model import Model


class SvfLs(Method):
    """Least squares after a state-variable filter F(s) = omega^n/(s + omega)^n on every channel.

    Parameters
    ----------
    omega : corner frequency, rad/s; None takes the one of 11 whose free run follows the training records best.
    order : number n of poles of the filter; at least the order of the highest derivative (3 for heading records and
        second-order response models).

    Response models need yaw rate or heading, and use both where both are measured; 3-DOF models need surge, sway and
    one of them.

    Exact without noise at every corner frequency within the sampling rate.  Noise that the filter leaves in the
    regressors (of heading and rudder) biases the estimate, most where a pole and a zero nearly cancel: for `patrol`
    (T2 .32 s, T3 .18 s) by 30 and 48 % at low noise, and at no corner frequency by less; `iv` and `output-error` have
    no such bias.
    """

    name = "svf-ls"
    title = "least squares on state-variable filtered records"
    search_space: ClassVar = {"omega": Real(1e-2, 30.0, log=True), "order": Integer(3, 6)}

    def __init__(self, omega: float | None = None, order: int = ORDER) -> None:
        self.omega, self.order = omega, order

    def check_options(self) -> None:
        super().check_options()
        if self.omega is not None and not self.omega > 0.0:
            raise BadInput(f"omega is {self.omega!r}, a positive number of rad/s is needed")
        if self.order < 3:
            raise BadInput(f"order is {self.order!r}, at least 3 is needed")

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
