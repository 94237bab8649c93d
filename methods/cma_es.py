"""A fit of the grey box by an evolution strategy: no derivatives, and a start from what is known beforehand."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ..datasets.record import Record
from ..estimation.likelihood.minimiser import Minimum
from ..estimation.likelihood.output_error import ADEQUATE, Outcome, as_fit, problem_of
from ..estimation.likelihood.problem import Problem, explains_records
from ..estimation.likelihood.unknowns import Unknowns
from ..estimation.results.fit import Fit
from ..models.errors import FitFailed
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
