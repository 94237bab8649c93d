"""Output error: the model that, run freely from an initial state, comes closest to the measured outputs.

Maximum likelihood for white sensor noise on yaw rate, heading, surge and sway (those that a record has), with the
standard deviation of each channel estimated too: the sum of N_c log s_c is minimised by Levenberg-Marquardt steps on
generated forward sensitivities.  Every step comes from orthogonal factors, so weakly identified directions keep the
accuracy that the records allow.

The cost has many minima.  Starts come from least squares, never from the true coefficients; the best are tried as they
are and after fits over growing horizons, where the run is restarted at measured states, or by multiple shooting.
Initial states are unknowns of the fit.  If no start reduces every residual to a few times its sensor's noise, the model
does not explain the records.  Free initial states would then hide what the model lacks, and the heading, which
integrates every error, would dominate the fit.  Runs then start where the records start, and heading only counts where
no yaw rate is measured.
Source: Jategaonkar 2015, Flight Vehicle System Identification, ch 4.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ...datasets.record import Record
from ...models.errors import CannotFit
from ...models.model import Model
from ..numerics import factors
from ..records.gaps import unbroken_series
from ..records.series import Series
from ..regression.starts import starts_of
from ..results.fit import Fit
from .linear_problem import NULL
from .loss import Loss
from .problem import Point, Problem, free_start_problem
from .search import Outcome, fit_output_error
from .shooting import ShootingProblem
from .unknowns import Unknowns


def identify(
    records: Sequence[Record],
    model: Model,
    unknowns: Unknowns | None = None,
    loss: Loss | None = None,
    max_iterations: int = 60,
    shooting: int = 1,
) -> Outcome:
    """Output-error fit of records from least-squares starts; arguments as in `search.fit_output_error`.

    Records are cut at long gaps and splices: every stretch has an initial state of its own.

    Raises
    ------
    CannotFit : a record lacks a channel, or there are no more measured values than unknowns.
    FitFailed : the model diverges from every start.
    """
    series, starts = _prepared(records, model, unknowns)
    return fit_output_error(series, model, starts, max_iterations, unknowns, loss, shooting)


def problem_of(
    records: Sequence[Record], model: Model, unknowns: Unknowns | None = None
) -> tuple[Problem, list[np.ndarray]]:
    """The problem with free initial states, and coefficients (p,) or estimated parameters (k,) to start from; raises as
    `identify`."""
    series, starts = _prepared(records, model, unknowns)
    return free_start_problem(series, model, unknowns), starts


def _prepared(
    records: Sequence[Record], model: Model, unknowns: Unknowns | None
) -> tuple[list[Series], list[np.ndarray]]:
    k = len(model.coordinates) if unknowns is None else len(unknowns.estimated)
    records, series = unbroken_series(records, model, k)
    return series, _starts(records, model, unknowns)


def _starts(records: Sequence[Record], model: Model, unknowns: Unknowns | None) -> list[np.ndarray]:
    """Coefficients (p,) or estimated parameters (k,) to start from; the means of a complete prior are among them."""
    found = starts_of(records, model)
    if unknowns is None:
        return [start.coefficients for start in found]
    starts = [unknowns.start(start.coefficients, start.source) for start in found]
    mean = unknowns.mean[unknowns.estimated]
    kept = [start for start in [*starts, mean] if start is not None and np.isfinite(start).all()]
    if not kept:
        raise CannotFit("least squares gives no start within the bounds")
    return kept


def as_fit(outcome: Outcome) -> Fit:
    """The outcome as a method's result, with the facts of the fit in `extra`."""
    problem, minimum = outcome.problem, outcome.minimum
    names, point, unknowns = problem.model.states, minimum.point, problem.unknowns
    covariance, rank = _covariance(problem, point)
    rms = np.sqrt(point.squares / np.maximum(problem.counts, 1.0))
    used = np.flatnonzero(problem.counts)
    shooting = isinstance(problem, ShootingProblem)
    extra = {
        "channels": [names[i] for i in used],
        "residual_sd": {names[i]: float(rms[i]) for i in used},
        "explains_records": outcome.adequate,
        "initial_states": "estimated" if outcome.adequate or shooting else "record",
        "attempts": outcome.n_attempts,
        "cost": minimum.cost,
    }
    if problem.loss is not None:
        extra["scale"] = {names[i]: float(point.sd[i]) for i in used}
    if isinstance(problem, ShootingProblem):
        jumps = problem.jumps(minimum.z)
        extra["jumps"] = {names[i]: float(np.abs(jumps[:, i]).max(initial=0.0)) for i in range(len(names))}
    return Fit(
        problem.coefficients(minimum.z),
        covariance if unknowns is None else unknowns.covariance(minimum.z[: problem.n_parameters], covariance),
        converged=minimum.converged,
        message=_message(outcome, rank),
        n_iterations=outcome.n_iterations,
        extra=extra,
        fixed=() if unknowns is None else unknowns.fixed_names,
    )


def _covariance(problem: Problem, point: Point) -> tuple[np.ndarray, int]:
    """Covariance (k, k) of the parameters, and how many directions of all unknowns the records determine."""
    if problem.arrow_shaped:
        arrow = problem.arrow(point, information=True)
        solution = factors.solve(arrow.shared, NULL)
        return solution.covariance, solution.rank + arrow.own_rank
    solution, n = factors.solve(problem.information(point), NULL), problem.n_parameters
    return solution.covariance[:n, :n], solution.rank


def _message(outcome: Outcome, rank: int) -> str:
    notes = [factors.rank_message(rank, outcome.problem.width)]
    if not outcome.adequate:
        notes.insert(0, "residuals exceed the sensor noise: the model does not explain the records")
    if at := _at_bounds(outcome):
        notes.append(f"at a bound: {', '.join(at)}")
    if isinstance(outcome.problem, ShootingProblem):
        notes.append("no free run follows whole records: the fit is one of stretches joined by multiple shooting")
    if not outcome.minimum.converged:
        notes.append("stopped before convergence")
    return "; ".join(filter(None, notes))


def _at_bounds(outcome: Outcome) -> list[str]:
    """Names of the parameters that are at one of their bounds."""
    problem = outcome.problem
    if problem.unknowns is None or not problem.unknowns.has_bounds:
        return []
    y, estimated = outcome.minimum.z[: problem.n_parameters], problem.unknowns.estimated
    at_bound = (y == problem.unknowns.low[estimated]) | (y == problem.unknowns.high[estimated])
    return [name for name, at in zip(problem.unknowns.names, at_bound, strict=True) if at]
