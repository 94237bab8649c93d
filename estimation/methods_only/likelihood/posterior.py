"""Draws from the posterior density of an output-error problem, by an affine-invariant ensemble of walkers.

The density is exp(-cost): the likelihood of white sensor noise, whose standard deviations are at their best values at
every point, times the prior where there is one; initial states are unknowns too.  Goodman & Weare 2010, Communications
in Applied Mathematics and Computational Science 5; sampled by emcee (Foreman-Mackey et al. 2013).
"""

from __future__ import annotations

import numpy as np

from ....models.errors import CannotFit, FitFailed
from ...likelihood.linear_problem import NULL
from ...likelihood.minimiser import Minimum
from ...likelihood.problem import Problem
from ...numerics import factors

LEAST_WALKERS = 24
DISCARDED = 0.5
"""Share of the steps after which the walkers have left their start."""


def sample(
    problem: Problem, minimum: Minimum, steps: int, walkers: int | None, seed: int
) -> tuple[np.ndarray, float, float]:
    """Draws from around a minimum of the cost.

    Parameters
    ----------
    steps : of every walker; the first half is left out.
    walkers : None: twice the unknowns and two, at least `LEAST_WALKERS`.

    Returns
    -------
    Draws (n, width) of the unknowns, the share of the proposals that were accepted, and the largest autocorrelation
    time of an unknown in steps.

    Raises
    ------
    CannotFit : the records leave an unknown open: without a prior its density has no mean.
    FitFailed : no proposal was accepted.
    """
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
