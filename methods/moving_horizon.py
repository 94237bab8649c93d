"""Moving-horizon estimation of states and coefficients."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, ClassVar

from ..estimation.methods_only.filters.joint import check_filter_options
from ..estimation.methods_only.likelihood.moving_horizon import Horizon, fit_moving_horizon
from ..estimation.methods_only.tuning.space import Integer, Real
from ..models.errors import BadInput
from .base import Method

if TYPE_CHECKING:
    from ..datasets.record import Record
    from ..estimation.results.fit import Fit
    from ..models.model import Model


class MovingHorizon(Method):
    """Output error in a horizon that moves along the records, with an arrival cost for all samples before it.

    Unknowns of a horizon are the coefficients and a state for every move; disturbances act between them.  The
    mathematics is in `helmbench.estimation.methods_only.likelihood.moving_horizon`.

    Parameters
    ----------
    horizon : samples of a horizon.
    step : share of the horizon by which it moves, 1 divided by a whole number.
    forgetting : factor on the information of the arrival cost at every move, above 0 and up to 1 (nothing is
        forgotten).  Below 1, the standard errors of coefficients that a manoeuvre does not excite grow with every move.
    passes : runs over all records at most; the last is the one after which the coefficients stand still.
    inflation : factor on the standard deviations of the least-squares start that make the first arrival cost.

    Records need the rudder and at least one of yaw rate, heading, surge and sway.  `trajectory` has a row for every
    horizon.
    """

    name = "moving-horizon"
    title = "moving-horizon estimation of states and coefficients with an arrival cost"
    minutes = True
    brief: ClassVar = {"passes": 2}
    search_space: ClassVar = {
        "horizon": Integer(30, 300, log=True),
        "forgetting": Real(0.98, 1.0),
        "inflation": Real(0.1, 1000.0, log=True),
    }
    order_matters = True

    def __init__(
        self,
        horizon: int = 120,
        step: float = 1.0 / 3.0,
        forgetting: float = 1.0,
        passes: int = 6,
        inflation: float = 5.0,
    ) -> None:
        self.horizon, self.step, self.forgetting = horizon, step, forgetting
        self.passes, self.inflation = passes, inflation

    def check_options(self) -> None:
        super().check_options()
        check_filter_options(self.passes, self.inflation)
        self.require_whole("horizon", 2)
        for name in ("step", "forgetting"):
            value = getattr(self, name)
            if not 0.0 < value <= 1.0:
                raise BadInput(f"{name} is {value!r}, a number above 0 and up to 1 is needed")
        moves = round(1.0 / self.step)
        if abs(moves * self.step - 1.0) > 1e-6:
            raise BadInput(f"step is {self.step!r}, 1 divided by a whole number is needed")

    def estimate(self, records: Sequence[Record], model: Model) -> Fit:
        horizon = Horizon(self.horizon, round(1.0 / self.step), self.forgetting)
        return fit_moving_horizon(records, model, horizon, self.passes, self.inflation)
