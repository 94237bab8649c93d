"""Searches without derivatives about output error: an evolution strategy, and the posterior density by walkers.

The density of `mcmc` is exp(-cost): the likelihood of white sensor noise, whose standard deviations are at their best
values at every point, times the prior where there is one; initial states are unknowns too.  Goodman & Weare 2010,
Communications in Applied Mathematics and Computational Science 5; sampled by emcee (Foreman-Mackey et al. 2013).
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ..datasets.record import Record
from ..estimation.likelihood.linear_problem import NULL
from ..estimation.likelihood.minimiser import Minimum
from ..estimation.likelihood.output_error import ADEQUATE, Outcome, as_fit, identify, problem_of
from ..estimation.likelihood.problem import Problem, explains_records
from ..estimation.likelihood.unknowns import Unknowns
from ..estimation.numerics import factors
from ..estimation.results.fit import Fit
from ..models.errors import BadInput, CannotFit, FitFailed
from ..models.model import Model
from .base import SEED, method
from .options import option, whole
from .output_error import PriorMethod

SPREAD = 0.5
"""Standard deviation of the start about least squares where there is no prior, relative to each unknown."""
EXPENSIVE = 1e12
"""Cost of a run that diverges."""


@method(
    "cma-es",
    "output error by an evolution strategy (CMA-ES), from priors",
    PriorMethod,
    minutes=True,
    brief={"evaluations": 600},
    order_matters=True,
)
def CmaEs(
    records: Sequence[Record],
    model: Model,
    unknowns: Unknowns | None,
    evaluations: int | None = option(None, "runs of all records at most; None: 400 for each unknown", whole(1)),
    seed: int = SEED,
) -> Fit:
    """Output error minimised by CMA-ES (Hansen 2016, arXiv 1604.00772) instead of steps along derivatives.

    The search starts from the mean of `prior` with its standard deviations; without a prior, from least squares with a
    half of each unknown.
    The cost is that of `output-error`, so that both have the same minimum: what differs is whether it is found.
    """
    problem, starts = problem_of(records, model.blanked(), unknowns)
    start = min(starts, key=lambda one: problem.at(problem.start(one)).cost)
    spread = SPREAD * np.abs(start)
    if unknowns is not None:
        mean, sd = unknowns.mean[unknowns.estimated], unknowns.sd[unknowns.estimated]
        start, spread = np.where(np.isfinite(sd), mean, start), np.where(np.isfinite(sd), sd, spread)
    z = problem.start(start)
    states = [s.start_sd[list(free)] for s, free in zip(problem.series, problem.free, strict=True)]
    sd = np.concatenate([spread, *states])
    sd = np.where(sd > 0.0, sd, 1e-3 * np.maximum(np.abs(z), 1.0))
    minimum = _search(problem, z, sd, evaluations or 400 * z.size, seed)
    adequate = explains_records(problem, minimum.point, ADEQUATE)
    return as_fit(Outcome(problem, minimum, adequate, 1, minimum.n_iterations))


def _search(problem: Problem, z: np.ndarray, sd: np.ndarray, most: int, seed: int) -> Minimum:
    """The best of `most` points tried at most; unknowns are counted from z in units of sd."""
    from cmaes import CMA

    limits, bounds = problem.limits(), None
    if limits is not None:
        z = np.clip(z, *limits)
        bounds = (np.stack(limits, axis=1) - z[:, None]) / sd[:, None]
    search = CMA(np.zeros(z.size), 1.0, bounds=bounds, seed=seed)
    best, count = problem.at(z), 1
    while count < most and not search.should_stop():
        told = []
        for _ in range(search.population_size):
            step = search.ask()
            point = problem.at(z + sd * step)
            told.append((step, min(point.cost, EXPENSIVE)))
            best = point if point.cost < best.cost else best
            count += 1
        search.tell(told)
    if not np.isfinite(best.cost):
        raise FitFailed("the simulation diverges at every point that was tried")
    return Minimum(best, search.should_stop(), count)


QUANTILES = (0.025, 0.5, 0.975)
ENOUGH = 50.0
"""Autocorrelation times that a chain must be long (Foreman-Mackey et al. 2013, documentation of emcee)."""
LEAST_WALKERS = 24
DISCARDED = 0.5
"""Share of the steps after which the walkers have left their start."""
MOST_SHOWN = 2000
"""Draws from which quantiles are taken."""


@method(
    "mcmc",
    "Bayes: posterior density of output error, ensemble sampler",
    PriorMethod,
    minutes=True,
    brief={"steps": 20},
    order_matters=True,
)
def Mcmc(
    records: Sequence[Record],
    model: Model,
    unknowns: Unknowns | None,
    steps: int = option(3500, "of every walker; the first half is left out", whole(20)),
    walkers: int | None = option(None, "None: twice the unknowns and two, at least 24", whole(4)),
    seed: int = option(0, "of the proposals", whole(0)),
) -> Fit:
    """Posterior mean and covariance of the grey box, by an ensemble sampler around the output-error estimate.

    `extra["quantiles"]` has the 2.5, 50 and 97.5 % quantiles of the published parameters.  `steps` are enough where
    they are fifty times `extra["autocorrelation_steps"]`; with fewer the fit says that it has not converged.
    """
    blank = model.blanked()
    outcome = identify(records, blank, unknowns)
    problem = outcome.problem
    least = 2 * problem.width
    if walkers is not None and walkers < least:
        raise BadInput(f"walkers is {walkers}, at least {least} are needed")
    draws, acceptance, time = _drawn(problem, outcome.minimum, steps, walkers, seed)
    coefficients = np.array([problem.coefficients(z) for z in draws])
    published = np.array([blank.to_parameters(c) for c in coefficients[:: -(-len(coefficients) // MOST_SHOWN)]])
    quantiles = np.quantile(published, QUANTILES, axis=0).T.tolist()
    extra = {
        "explains_records": outcome.adequate,
        "draws": len(draws),
        "acceptance": acceptance,
        "autocorrelation_steps": time,
        "quantiles": dict(zip(blank.parameter_names, quantiles, strict=True)),
    }
    enough = ENOUGH * time < steps
    return Fit(
        coefficients.mean(axis=0),
        np.atleast_2d(np.cov(coefficients, rowvar=False)),
        converged=enough,
        message="" if enough else f"fewer steps than {ENOUGH:g} autocorrelation times of {time:.3g} steps",
        n_iterations=steps,
        extra=extra,
        fixed=() if unknowns is None else unknowns.fixed_names,
    )


def _drawn(
    problem: Problem, minimum: Minimum, steps: int, walkers: int | None, seed: int
) -> tuple[np.ndarray, float, float]:
    """Draws (n, width) of the unknowns from around a minimum of the cost, the share of the proposals that were
    accepted, and the largest autocorrelation time of an unknown in steps."""
    import emcee

    solution = factors.solve(problem.information(minimum.point), NULL)
    if not np.isfinite(np.diag(solution.covariance)).all():
        raise CannotFit("the records do not determine every unknown: give a prior, or fix parameters")
    rng, count = np.random.default_rng(seed), walkers or max(LEAST_WALKERS, 2 * problem.width + 2)
    limits = problem.limits()

    def log_density(z: np.ndarray) -> float:
        if limits is not None and ((z < limits[0]) | (z > limits[1])).any():
            return -np.inf
        return -problem.at(z).cost

    start = minimum.z + 0.5 * rng.standard_normal((count, solution.half.shape[1])) @ solution.half.T
    if limits is not None:
        start = np.clip(start, *limits)
    sampler = emcee.EnsembleSampler(count, problem.width, log_density)
    sampler.random_state = np.random.RandomState(rng.integers(2**32)).get_state()
    with np.errstate(all="ignore"):
        sampler.run_mcmc(start, steps, skip_initial_state_check=True)
        times = sampler.get_autocorr_time(discard=int(DISCARDED * steps), quiet=True, tol=0)
    acceptance = float(np.mean(sampler.acceptance_fraction))
    if not acceptance > 0.0:
        raise FitFailed("no proposal was accepted: the density has no width around its largest value")
    draws = np.asarray(sampler.get_chain(discard=int(DISCARDED * steps), flat=True))
    return draws, acceptance, float(np.max(times))
