"""Output error: the model that, run freely from an initial state, comes closest to the measured outputs.

Maximum likelihood for white sensor noise on yaw rate, heading, surge and sway (those that a record has), with the
standard deviation of each channel estimated along: the sum of N_c log s_c is minimised by Levenberg-Marquardt steps on
generated forward sensitivities.  Every step comes from orthogonal factors, so weakly identified directions keep the
accuracy that the records give them.

The cost has many minima.  Starts come from least squares, never from the truth; the best are tried as they are and
after fits over growing horizons, where the run is restarted at measured states, or by multiple shooting.
Initial states are unknowns of the fit.  If no start brings every residual down to a few times its sensor's noise, the
model does not explain the records: free initial states would then bend to hide that, and the heading, which integrates
every error, would rule the fit.  Runs then start where the records start, and heading only counts where no yaw rate
is measured.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from ..models.errors import BadInput
from . import factors
from .base import CannotFit, Fit, Method
from .likelihood import options
from .likelihood.loss import loss_of
from .likelihood.minimiser import NULL
from .likelihood.profile import profile
from .likelihood.search import Outcome, fit_output_error
from .likelihood.shooting import Chain
from .likelihood.unknowns import Unknowns
from .series import series_of
from .starts import starts_of

if TYPE_CHECKING:
    from ..datasets.record import Record
    from ..models.model import Model

MOST_STRETCHES = 1000


class OutputError(Method):
    """Output error by multi-start Levenberg-Marquardt on generated sensitivities; initial states are nuisances.

    Parameters
    ----------
    max_iterations : of one minimisation.
    shooting : stretches into which every record is cut by multiple shooting, for long records and for ships that are
        unstable on their course; 1: none.
    prior : what is known of published parameters, as Gaussian densities: a mapping name -> (mean, standard deviation),
        or a share of the given model's own values (0.3: a standard deviation of 30 %; what is zero there stays zero).
    bounds : mapping name -> (low, high) of published parameters, None for no bound.
    fixed : parameters that are not estimated: a mapping name -> value, or names (a list, or joined by +) kept at the
        given model's values.
    loss : 'gauss' (or None), 'huber' or 'student', of residuals in units of their channel's scale.
    tuning : Huber's bend in standard deviations (1.345), Student's degrees of freedom (4).
    profile : names (a list, or joined by +) or 'all': profile-likelihood intervals in `extra["profile"]`.
    level : of these intervals.

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
        for name, reader in (("prior", options.priors), ("bounds", options.limits), ("fixed", options.fixings)):
            if getattr(self, name) is not None:
                reader(getattr(self, name))
        if self.profile is not None:
            options.names("profile", self.profile)

    def seen(self, model: Model) -> Model:
        return model

    def estimate(self, records: Sequence[Record], model: Model) -> Fit:
        unknowns = options.unknowns_of(model, self.prior, self.bounds, self.fixed)
        wanted, model = _wanted(self.profile, model), model.blanked()
        series = [series_of(record, model) for record in records]
        k = len(model.coordinates) if unknowns is None else len(unknowns.moving)
        if (n := sum(s.n_outputs for s in series)) <= k:
            raise CannotFit(f"{n} measured values for {k} coefficients")
        starts = starts_among(records, model, unknowns)
        loss = loss_of(self.loss, self.tuning)
        outcome = fit_output_error(series, model, starts, self.max_iterations, unknowns, loss, self.shooting)
        fit = _fit(outcome)
        if not wanted:
            return fit
        found = {name: interval._asdict() for name, interval in profile(outcome, wanted, self.level).items()}
        return fit._replace(extra={**fit.extra, "profile": found, "profile_level": self.level})


def starts_among(records: Sequence[Record], model: Model, unknowns: Unknowns | None) -> list[np.ndarray]:
    """Coefficients (p,) to start from, or the parameters (k,) that move; the prior's means among them if complete."""
    found = starts_of(records, model)
    if unknowns is None:
        return [start.coefficients for start in found]
    starts = [unknowns.start(start.coefficients, start.source) for start in found]
    mean = unknowns.mean[unknowns.moving]
    kept = [start for start in [*starts, mean] if start is not None and np.isfinite(start).all()]
    if not kept:
        raise CannotFit("least squares gives no start within the bounds")
    return kept


def _wanted(names: Any, model: Model) -> list[int]:
    if names is None:
        return []
    given = options.names("profile", names)
    return list(range(len(model.parameter_names))) if given == ["all"] else options.indices("profile", given, model)


def _fit(outcome: Outcome) -> Fit:
    problem, minimum = outcome.problem, outcome.minimum
    names, point, unknowns = problem.model.states, minimum.point, problem.unknowns
    solution = factors.solve(problem.information(point), NULL)
    covariance = solution.covariance[: problem.own, : problem.own]
    rms = np.sqrt(point.squares / np.maximum(problem.counts, 1.0))
    used = np.flatnonzero(problem.counts)
    extra = {
        "channels": [names[i] for i in used],
        "residual_sd": {names[i]: float(rms[i]) for i in used},
        "explains_records": outcome.adequate,
        "initial_states": "estimated" if outcome.adequate or isinstance(problem, Chain) else "record",
        "attempts": outcome.n_attempts,
        "cost": minimum.cost,
    }
    if problem.loss is not None:
        extra["scale"] = {names[i]: float(point.sd[i]) for i in used}
    if isinstance(problem, Chain):
        jumps = problem.jumps(minimum.z)
        extra["jumps"] = {names[i]: float(np.abs(jumps[:, i]).max(initial=0.0)) for i in range(len(names))}
    return Fit(
        problem.coefficients(minimum.z),
        covariance if unknowns is None else unknowns.covariance(minimum.z[: problem.own], covariance),
        converged=minimum.converged,
        message=_message(outcome, solution.rank),
        n_iterations=outcome.n_iterations,
        extra=extra,
        fixed=() if unknowns is None else unknowns.held,
    )


def _message(outcome: Outcome, rank: int) -> str:
    said = [] if outcome.adequate else ["residuals exceed the sensor noise: the model does not explain the records"]
    if rank < outcome.problem.width:
        said.append(f"the records determine {rank} of {outcome.problem.width} directions")
    if at := _at_bounds(outcome):
        said.append(f"at a bound: {', '.join(at)}")
    if isinstance(outcome.problem, Chain):
        said.append("no free run follows whole records: stretches joined by multiple shooting do")
    if not outcome.minimum.converged:
        said.append("stopped before convergence")
    return "; ".join(said)


def _at_bounds(outcome: Outcome) -> list[str]:
    problem = outcome.problem
    if problem.unknowns is None or not problem.unknowns.bounded:
        return []
    y, moving = outcome.minimum.z[: problem.own], problem.unknowns.moving
    touched = (y == problem.unknowns.low[moving]) | (y == problem.unknowns.high[moving])
    return [name for name, at in zip(problem.unknowns.names, touched, strict=True) if at]
