"""Joint state and parameter estimation by Kalman filters: extended and unscented."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from ..datasets.record import Record
from ..estimation.methods_only.filters.joint import joint_fit
from ..estimation.methods_only.tuning.space import Real
from ..estimation.results.fit import Fit
from ..models.model import Model
from .base import method
from .options import POSITIVE, SHARE, number, option, whole

PASSES: Any = option(4, "runs over all records", whole(1))
INFLATION: Any = option(
    5.0,
    "factor on the standard deviations of the least-squares start that make the prior",
    POSITIVE,
    Real(0.1, 1000.0, log=True),
)


@method("ekf", "joint state and parameter extended Kalman filter", order_matters=True)
def Ekf(records: Sequence[Record], model: Model, passes: int = PASSES, inflation: float = INFLATION) -> Fit:
    """Joint extended Kalman filter, iterated, with a smoother of the initial states.

    Each sample is predicted by one RK4 sample step with its generated sensitivities; each measured channel is a scalar
    update in Joseph form, gaps are skipped (`helmbench.estimation.methods_only.filters.joint`).

    Records need the rudder and at least one of yaw rate, heading, surge and sway.  `extra` holds the innovations of
    the last pass (per record (N, c), in the order of `channels`) for one-step scores.
    """
    return joint_fit(records, model, passes, inflation)


@method("ukf", "joint state and parameter unscented Kalman filter", order_matters=True)
def Ukf(
    records: Sequence[Record],
    model: Model,
    passes: int = PASSES,
    inflation: float = INFLATION,
    alpha: float = option(
        0.1,
        "distance of the sigma points in units of sqrt(m) standard deviations, m being the size of the joint vector",
        SHARE,
        Real(1e-3, 1.0, log=True),
    ),
    beta: float = option(
        2.0,
        "weight of the mean's shift in the covariance; 2 for Gaussian densities",
        number("a number of at least 1", lambda value: value >= 1.0),
    ),
) -> Fit:
    """Joint unscented Kalman filter, iterated as `ekf` is.

    Starting values, sensor and process noise, and the initial states between passes are those of `ekf`.
    """
    return joint_fit(records, model, passes, inflation, (alpha, beta))
