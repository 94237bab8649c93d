"""Output error: the model that, run freely from an initial state, comes closest to the measured outputs."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

from ..estimation.likelihood.loss import loss_of
from ..estimation.likelihood.output_error import as_fit, identify
from ..estimation.methods_only.likelihood import options
from ..estimation.methods_only.likelihood.profile import profile
from ..models.errors import BadInput
from .prior_method import PriorMethod

if TYPE_CHECKING:
    from ..datasets.record import Record
    from ..estimation.results.fit import Fit
    from ..models.model import Model

MOST_STRETCHES = 1000


class OutputError(PriorMethod):
    """Output error by multi-start Levenberg-Marquardt on generated sensitivities.

    Initial states are estimated too.  The mathematics is in `helmbench.estimation.likelihood.output_error`.

    Parameters
    ----------
    max_iterations : iterations of one minimisation at most.
    shooting : stretches into which every record is cut by multiple shooting, for long records and for ships that are
        unstable on their course; 1: none.
    prior : Gaussian densities of published parameters: a mapping name -> (mean, standard deviation), or a standard
        deviation relative to the given model's own values (0.3: 30 %; parameters that are zero there stay zero).
    bounds : mapping name -> (low, high) of published parameters, None for no bound.
    fixed : parameters that are not estimated: a mapping name -> value, or names (a list, or joined by +) that keep the
        given model's values.
    loss : 'gauss' (or None), 'huber' or 'student', of residuals in units of their channel's scale.
    tuning : Huber's bend in standard deviations (1.345), Student's degrees of freedom (4).
    profile : names (a list, or joined by +) or 'all': profile-likelihood intervals in `extra["profile"]`.
    level : confidence level of these intervals.

    `prior`, `bounds` and `fixed` may also be paths of YAML or JSON files that hold the mapping.

    Records need the rudder and at least one of yaw rate, heading, surge and sway.  `extra` says which channels were
    fitted, whether initial states were estimated, and the residual of each channel.
    """

    name = "output-error"
    title = "output error: free run against the record, multi-start Levenberg-Marquardt"

    def __init__(
        self,
        max_iterations: int = 60,
        shooting: int = 1,
        prior: Any = None,
        bounds: Any = None,
        fixed: Any = None,
        loss: str | None = None,
        tuning: float | None = None,
        profile: Any = None,
        level: float = 0.95,
    ) -> None:
        self.max_iterations, self.shooting = max_iterations, shooting
        self.prior, self.bounds, self.fixed = prior, bounds, fixed
        self.loss, self.tuning = loss, tuning
        self.profile, self.level = profile, level

    def check_options(self) -> None:
        super().check_options()
        for name, most in (("max_iterations", None), ("shooting", MOST_STRETCHES)):
            value = getattr(self, name)
            if isinstance(value, bool) or not isinstance(value, int) or value < 1 or value > (most or value):
                allowed = "a whole number, at least 1, is needed" if most is None else f"1 to {most} are possible"
                raise BadInput(f"{name} is {value!r}, {allowed}")
        if not (isinstance(self.level, float) and 0.0 < self.level < 1.0):
            raise BadInput(f"level is {self.level!r}, a number between 0 and 1 is needed")
        loss_of(self.loss, self.tuning)
        if self.profile is not None:
            options.names("profile", self.profile)

    def estimate(self, records: Sequence[Record], model: Model) -> Fit:
        unknowns = self.unknowns(model)
        wanted = options.profiled(self.profile, model)
        loss = loss_of(self.loss, self.tuning)
        outcome = identify(records, model.blanked(), unknowns, loss, self.max_iterations, self.shooting)
        fit = as_fit(outcome)
        if not wanted:
            return fit
        intervals = {name: interval._asdict() for name, interval in profile(outcome, wanted, self.level).items()}
        return fit._replace(extra={**fit.extra, "profile": intervals, "profile_level": self.level})
