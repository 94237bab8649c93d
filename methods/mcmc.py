"""Bayesian identification: the posterior density of the parameters, sampled by an affine-invariant ensemble of walkers.

The density is exp(-cost): the likelihood of white sensor noise, whose standard deviations are at their best values at
every point, times the prior where there is one; initial states are unknowns too.  Goodman & Weare 2010, Communications
in Applied Mathematics and Computational Science 5; sampled by emcee (Foreman-Mackey et al. 2013).
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ..datasets.record import Record
from ..estimation.likelihood.linear_problem import NULL
from ..estimation.likelihood.minimiser import Minimum
from ..estimation.likelihood.output_error import identify
from ..estimation.likelihood.problem import Problem
from ..estimation.likelihood.unknowns import Unknowns
from ..estimation.numerics import factors
from ..estimation.results.fit import Fit
from ..models.errors import BadInput, CannotFit, FitFailed
from ..models.model import Model
from .base import method
from .options import option, whole
from .output_error import PriorMethod

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
