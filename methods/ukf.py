"""Joint state and parameter estimation by an unscented Kalman filter."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, ClassVar

from ..estimation.methods_only.filters.joint import check_filter_options, joint_fit
from ..estimation.methods_only.filters.unscented import Unscented
from ..estimation.methods_only.tuning.space import Real
from ..models.errors import BadInput
from .base import Method

if TYPE_CHECKING:
    from ..datasets.record import Record
    from ..estimation.results.fit import Fit
    from ..models.model import Model


class Ukf(Method):
    """Joint unscented Kalman filter, iterated as `ekf` is.

    Parameters
    ----------
    passes, inflation : as in `ekf`.
    alpha : distance of the sigma points in units of sqrt(m) standard deviations, m being the size of the joint vector.
    beta : weight of the mean's shift in the covariance; 2 for Gaussian densities.

    Starting values, sensor and process noise, and the initial states between passes are those of `ekf`.
    """

    name = "ukf"
    title = "joint state and parameter unscented Kalman filter"
    search_space: ClassVar = {"inflation": Real(0.1, 1000.0, log=True), "alpha": Real(1e-3, 1.0, log=True)}
    order_matters = True

    def __init__(self, passes: int = 4, inflation: float = 5.0, alpha: float = 0.1, beta: float = 2.0) -> None:
        self.passes, self.inflation, self.alpha, self.beta = passes, inflation, alpha, beta

    def check_options(self) -> None:
        super().check_options()
        check_filter_options(self.passes, self.inflation)
        if not 0.0 < self.alpha <= 1.0:
            raise BadInput(f"alpha is {self.alpha!r}, a number above 0 and up to 1 is needed")
        if not self.beta >= 1.0:
            raise BadInput(f"beta is {self.beta!r}, at least 1 is needed")

    def estimate(self, records: Sequence[Record], model: Model) -> Fit:
        return joint_fit(records, model, self.passes, self.inflation, Unscented(self.alpha, self.beta))
