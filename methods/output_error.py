"""Output error: the model that, run freely from an initial state, comes closest to the measured outputs."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Any, NamedTuple

import numpy as np

from ..datasets.record import Record
from ..estimation.likelihood.linear_problem import NULL
from ..estimation.likelihood.loss import TUNING, loss_of
from ..estimation.likelihood.minimiser import levenberg_marquardt
from ..estimation.likelihood.output_error import Outcome, as_fit, identify
from ..estimation.likelihood.problem import Problem
from ..estimation.likelihood.unknowns import Unknowns
from ..estimation.methods_only import prior_knowledge as knowledge
from ..estimation.numerics import factors
from ..estimation.results.fit import Fit
from ..models.model import Model
from .base import Method
from .options import number, option, whole, words

MOST_STRETCHES = 1000


class PriorMethod(Method):
    """Base of methods that take prior knowledge of the published parameters; the function gets the unknowns beside
    records and model, None for all coefficients."""

    prior: Any = option(
        None,
        "Gaussian densities of published parameters: a mapping name -> (mean, standard deviation), or a standard "
        "deviation relative to the given model's own values (0.3: 30 %; parameters that are zero there stay zero)",
        lambda _, value: knowledge.priors(value),
    )
    bounds: Any = option(
        None,
        "mapping name -> (low, high) of published parameters, None for no bound",
        knowledge.entries,
    )
    fixed: Any = option(
        None,
        "parameters that are not estimated: a mapping name -> value, or names (a list, or joined by +) that keep the "
        "given model's values",
        lambda _, value: knowledge.fixings(value),
    )

    def visible(self, model: Model) -> Model:
        return model

    def estimate(self, records: Sequence[Record], model: Model) -> Fit:
        return self.computed(records, model, self.unknowns(model))

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


TRIALS = 14
"""Refits on each side at most; a limit that is not found by then is open."""
CLOSE = 0.02
"""Relative error of the likelihood ratio's root at which the search for a limit stops."""
ITERATIONS, GAIN = 60, 1e-4
"""Of a refit: iterations at most, and the predicted gain at which it stops."""
FIRST = 0.1
"""First step of a parameter without a standard error, relative to its size."""


class Interval(NamedTuple):
    """A confidence interval.

    A limit is open where the likelihood ratio stays below its threshold up to there: at a bound of the parameter, at a
    value beyond which runs diverge, or at infinity.
    """

    low: float
    high: float
    low_open: bool
    high_open: bool


def profile(outcome: Outcome, indices: Sequence[int], level: float) -> dict[str, Interval]:
    """Intervals of published parameters by name: 2 (cost - least cost) <= the chi-square quantile of `level`.

    Prior and bounds of the other parameters still apply; a parameter's own prior counts as data.  With a robust loss
    the ratio is scaled as M-estimation requires.
    """
    from scipy.special import chdtri

    problem, z = _public(outcome.problem, outcome.minimum.z)
    point = problem.at(z)
    threshold = float(np.sqrt(chdtri(1, 1.0 - level) / point.ratio))
    solution = factors.solve(problem.information(point), NULL)
    unknowns = problem.unknowns
    assert unknowns is not None
    estimated = unknowns.estimated.tolist()
    found = {}
    for index in indices:
        if index not in estimated:
            value = float(unknowns.values[index])
            found[unknowns.model.parameter_names[index]] = Interval(value, value, False, False)
            continue
        search = _Profile(problem, z, point.cost, estimated.index(index), index, threshold, solution.covariance)
        (low, low_open), (high, high_open) = search.limit(-1.0), search.limit(1.0)
        found[unknowns.model.parameter_names[index]] = Interval(low, high, low_open, high_open)
    return found


def _public(problem: Problem, z: np.ndarray) -> tuple[Problem, np.ndarray]:
    """The problem with published parameters as unknowns."""
    if problem.unknowns is not None:
        return problem, z
    public = replace(problem, unknowns=Unknowns.all_of(problem.model))
    return public, np.concatenate([problem.model.to_parameters(z[: problem.n_parameters]), z[problem.n_parameters :]])


class _Profile(NamedTuple):
    """The profile likelihood of the parameter `index`, which is the unknown `place`, about the minimum z (width,)."""

    problem: Problem
    z: np.ndarray
    least: float
    place: int
    index: int
    threshold: float
    covariance: np.ndarray

    def limit(self, sign: float) -> tuple[float, bool]:
        """The value at which the root of twice the likelihood ratio reaches the threshold, by false position, and
        whether the interval is open there."""
        centre = float(self.z[self.place])
        bound = self._bound(sign)
        step, reached = self._first_step(), 0.0
        inner, outer = (0.0, 0.0), None
        start = self.z
        for _ in range(TRIALS):
            value = centre + sign * step
            at_bound = sign * (value - bound) >= 0.0
            value = bound if at_bound else value
            step = abs(value - centre)
            root, start = self._refit(value, start)
            if abs(root / self.threshold - 1.0) < CLOSE:
                return value, False
            if root < self.threshold:
                if at_bound:
                    return bound, True
                inner, reached = (step, root), step
            else:
                outer = (step, root)
                start = self.z
            step = self._next(inner, outer, step)
        if outer is None:
            return sign * np.inf, True
        return centre + sign * reached, not outer[1] < 2.0 * self.threshold  # open where runs diverge beyond it

    def _bound(self, sign: float) -> float:
        unknowns = self.problem.unknowns
        assert unknowns is not None
        return float((unknowns.high if sign > 0.0 else unknowns.low)[self.index])

    def _first_step(self) -> float:
        variance = self.covariance[self.place, self.place]
        if np.isfinite(variance) and variance > 0.0:
            return self.threshold * float(np.sqrt(variance))
        return FIRST * (abs(float(self.z[self.place])) or 1.0)

    def _next(self, inner: tuple[float, float], outer: tuple[float, float] | None, step: float) -> float:
        if outer is None:
            growth = self.threshold / inner[1] if inner[1] > 0.0 else 4.0
            return step * min(max(1.05 * growth, 1.1), 4.0)
        if not np.isfinite(outer[1]):
            return 0.5 * (inner[0] + outer[0])
        share = (self.threshold - inner[1]) / (outer[1] - inner[1])
        return inner[0] + min(max(share, 0.1), 0.9) * (outer[0] - inner[0])

    def _refit(self, value: float, start: np.ndarray) -> tuple[float, np.ndarray]:
        """Root of twice the likelihood ratio with the parameter fixed at `value`, and the unknowns there."""
        unknowns = self.problem.unknowns
        assert unknowns is not None
        others = unknowns.with_fixed(self.index, value)
        fixed = replace(self.problem, unknowns=others)
        for guess in (self._predicted(value), start):
            z = np.delete(guess, self.place)
            z[: fixed.n_parameters] = others.clipped(z[: fixed.n_parameters])
            if np.isfinite(fixed.at(z).cost):
                found = levenberg_marquardt(fixed, z, ITERATIONS, GAIN)
                root = float(np.sqrt(2.0 * max(found.cost - self.least, 0.0)))
                return root, np.insert(found.z, self.place, value)
        return np.inf, start

    def _predicted(self, value: float) -> np.ndarray:
        """The unknowns at the minimum with the parameter at `value`, if the cost is quadratic."""
        variance = self.covariance[self.place, self.place]
        predicted = self.z.copy()
        if np.isfinite(variance) and variance > 0.0:
            column = np.where(np.isfinite(np.diag(self.covariance)), self.covariance[:, self.place], 0.0)
            predicted += column / variance * (value - self.z[self.place])
        predicted[self.place] = value
        return predicted
