"""Moving-horizon estimation of states and coefficients."""

from __future__ import annotations

from collections.abc import Sequence
from typing import ClassVar

from ..datasets.record import Record
from ..estimation.methods_only.likelihood.moving_horizon import Horizon, fit_moving_horizon
from ..estimation.methods_only.tuning.space import Integer, Real
from ..estimation.results.fit import Fit
from ..models.errors import BadInput
from ..models.model import Model
from .base import Method
from .options import POSITIVE, SHARE, option, whole


class MovingHorizon(Method):
    """Output error in a horizon that moves along the records, with an arrival cost for all samples before it.

    Unknowns of a horizon are the coefficients and a state for every move; disturbances act between them.  The
    mathematics is in `helmbench.estimation.methods_only.likelihood.moving_horizon`.

    Records need the rudder and at least one of yaw rate, heading, surge and sway.  `trajectory` has a row for every
    horizon.
    """

    name = "moving-horizon"
    title = "moving-horizon estimation of states and coefficients with an arrival cost"
    minutes = True
    brief: ClassVar = {"passes": 2}
    order_matters = True

    horizon: int = option(120, "samples of a horizon", whole(2), Integer(30, 300, log=True))
    step: float = option(1.0 / 3.0, "share of the horizon by which it moves, 1 divided by a whole number", SHARE)
    forgetting: float = option(
        1.0,
        "factor on the information of the arrival cost at every move; at 1 nothing is forgotten, below 1 the standard "
        "errors of coefficients that a manoeuvre does not excite grow with every move",
        SHARE,
        Real(0.98, 1.0),
    )
    passes: int = option(
        6, "runs over all records at most; the last is the one after which the coefficients stand still", whole(1)
    )
    inflation: float = option(
        5.0,
        "factor on the standard deviations of the least-squares start that make the first arrival cost",
        POSITIVE,
        Real(0.1, 1000.0, log=True),
    )

    def check_options(self) -> None:
        super().check_options()
        moves = round(1.0 / self.step)
        if abs(moves * self.step - 1.0) > 1e-6:
            raise BadInput(f"step is {self.step!r}, 1 divided by a whole number is needed")

    def estimate(self, records: Sequence[Record], model: Model) -> Fit:
        horizon = Horizon(self.horizon, round(1.0 / self.step), self.forgetting)
        return fit_moving_horizon(records, model, horizon, self.passes, self.inflation)
