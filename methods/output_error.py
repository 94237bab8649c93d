"""Output error: the model that, run freely from an initial state, comes closest to the measured outputs."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from ..datasets.record import Record
from ..estimation.likelihood.loss import TUNING, loss_of
from ..estimation.likelihood.output_error import as_fit, identify
from ..estimation.likelihood.unknowns import Unknowns
from ..estimation.methods_only.likelihood import options as knowledge
from ..estimation.methods_only.likelihood.profile import profile
from ..estimation.results.fit import Fit
from ..models.model import Model
from .base import Method
from .options import number, option, whole, words

MOST_STRETCHES = 1000


class PriorMethod(Method):
    """Base class of methods that take prior knowledge of the published parameters."""

    prior: Any = option(
        None,
        "Gaussian densities of published parameters: a mapping name -> (mean, standard deviation), or a standard "
        "deviation relative to the given model's own values (0.3: 30 %; parameters that are zero there stay zero)",
        lambda _, value: knowledge.priors(value),
    )
    bounds: Any = option(
        None,
        "mapping name -> (low, high) of published parameters, None for no bound",
        lambda _, value: knowledge.limits(value),
    )
    fixed: Any = option(
        None,
        "parameters that are not estimated: a mapping name -> value, or names (a list, or joined by +) that keep the "
        "given model's values",
        lambda _, value: knowledge.fixings(value),
    )

    def visible(self, model: Model) -> Model:
        return model

    def unknowns(self, model: Model) -> Unknowns | None:
        """The parameters that are estimated of a model with the known values; None: all coefficients, freely."""
        return knowledge.unknowns_of(model, self.prior, self.bounds, self.fixed)


class OutputError(PriorMethod):
    """Output error by multi-start Levenberg-Marquardt on generated sensitivities.

    Initial states are estimated too.  The mathematics is in `helmbench.estimation.likelihood.output_error`.

    `prior`, `bounds` and `fixed` may also be paths of YAML or JSON files that hold the mapping.

    Records need the rudder and at least one of yaw rate, heading, surge and sway.  `extra` says which channels were
    fitted, whether initial states were estimated, and the residual of each channel.
    """

    name = "output-error"
    title = "output error: free run against the record, multi-start Levenberg-Marquardt"

    max_iterations: int = option(60, "iterations of one minimisation at most", whole(1))
    shooting: int = option(
        1,
        "stretches into which every record is cut by multiple shooting, for long records and for ships that are "
        "unstable on their course; 1: none",
        whole(1, MOST_STRETCHES),
    )
    loss: str | None = option(
        None,
        "'gauss' (or None), 'huber' or 'student', of residuals in units of their channel's scale",
        words("loss", ("gauss", *TUNING)),
    )
    tuning: float | None = option(None, "Huber's bend in standard deviations (1.345), Student's degrees of freedom (4)")
    profile: Any = option(
        None,
        "names (a list, or joined by +) or 'all': profile-likelihood intervals in `extra[\"profile\"]`",
        knowledge.names,
    )
    level: float = option(
        0.95,
        "confidence level of these intervals",
        number("a number between 0 and 1", lambda value: 0.0 < value < 1.0),
    )

    def check_options(self) -> None:
        super().check_options()
        loss_of(self.loss, self.tuning)

    def estimate(self, records: Sequence[Record], model: Model) -> Fit:
        unknowns = self.unknowns(model)
        wanted = knowledge.profiled(self.profile, model)
        loss = loss_of(self.loss, self.tuning)
        outcome = identify(records, model.blanked(), unknowns, loss, self.max_iterations, self.shooting)
        fit = as_fit(outcome)
        if not wanted:
            return fit
        intervals = {name: interval._asdict() for name, interval in profile(outcome, wanted, self.level).items()}
        return fit._replace(extra={**fit.extra, "profile": intervals, "profile_level": self.level})
