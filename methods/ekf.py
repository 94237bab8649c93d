"""Joint state and parameter estimation by an extended Kalman filter with a Rauch-Tung-Striebel smoother."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, ClassVar

from ..estimation.methods_only.filters.joint import check_filter_options, extended, joint_fit
from ..estimation.methods_only.tuning.space import Real
from .base import Method

if TYPE_CHECKING:
    from ..datasets.record import Record
    from ..estimation.results.fit import Fit
    from ..models.model import Model


class Ekf(Method):
    """Joint extended Kalman filter with smoother, iterated.

    Each sample is predicted by one RK4 sample step with its generated sensitivities; each measured channel is a scalar
    update in Joseph form, gaps are skipped (`helmbench.estimation.methods_only.filters.joint`).

    Parameters
    ----------
    passes : runs over all records.
    inflation : factor on the standard deviations of the least-squares start that make the prior.

    Records need the rudder and at least one of yaw rate, heading, surge and sway.  `extra` holds the innovations of
    the last pass (per record (N, c), in the order of `channels`) for one-step scores.
    """

    name = "ekf"
    title = "joint state and parameter extended Kalman filter with RTS smoother"
    search_space: ClassVar = {"inflation": Real(0.1, 1000.0, log=True)}
    order_matters = True

    def __init__(self, passes: int = 4, inflation: float = 5.0) -> None:
        self.passes, self.inflation = passes, inflation

    def check_options(self) -> None:
        super().check_options()
        check_filter_options(self.passes, self.inflation)

    def estimate(self, records: Sequence[Record], model: Model) -> Fit:
        return joint_fit(records, model, self.passes, self.inflation, extended)
