"""Bayesian identification: the posterior density of the parameters, sampled."""

from __future__ import annotations

from collections.abc import Sequence
from typing import ClassVar

import numpy as np

from ..datasets.record import Record
from ..estimation.likelihood.output_error import identify
from ..estimation.methods_only.likelihood.posterior import sample
from ..estimation.results.fit import Fit
from ..models.errors import BadInput
from ..models.model import Model
from .options import option, whole
from .output_error import PriorMethod

QUANTILES = (0.025, 0.5, 0.975)
ENOUGH = 50.0
"""Autocorrelation times that a chain must be long (Foreman-Mackey et al. 2013, documentation of emcee)."""
MOST_SHOWN = 2000
"""Draws from which quantiles are taken."""


class Mcmc(PriorMethod):
    """Posterior mean and covariance of the grey box, by an ensemble sampler around the output-error estimate.

    The density and its sampler are those of `helmbench.estimation.methods_only.likelihood.posterior`.
    `extra["quantiles"]` has the 2.5, 50 and 97.5 % quantiles of the published parameters.  `steps` are enough where
    they are fifty times `extra["autocorrelation_steps"]`; with fewer the fit says that it has not converged.
    """

    name = "mcmc"
    title = "Bayes: posterior density of output error, ensemble sampler"
    minutes = True
    brief: ClassVar = {"steps": 20}
    order_matters = True

    steps: int = option(3500, "of every walker; the first half is left out", whole(20))
    walkers: int | None = option(None, "None: twice the unknowns and two, at least 24", whole(4))
    seed: int = option(0, "of the proposals", whole(0))

    def estimate(self, records: Sequence[Record], model: Model) -> Fit:
        unknowns = self.unknowns(model)
        blank = model.blanked()
        outcome = identify(records, blank, unknowns)
        problem = outcome.problem
        least = 2 * problem.width
        if self.walkers is not None and self.walkers < least:
            raise BadInput(f"walkers is {self.walkers}, at least {least} are needed")
        draws, acceptance, time = sample(problem, outcome.minimum, self.steps, self.walkers, self.seed)
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
        enough = ENOUGH * time < self.steps
        return Fit(
            coefficients.mean(axis=0),
            np.atleast_2d(np.cov(coefficients, rowvar=False)),
            converged=enough,
            message="" if enough else f"fewer steps than {ENOUGH:g} autocorrelation times of {time:.3g} steps",
            n_iterations=self.steps,
            extra=extra,
            fixed=() if unknowns is None else unknowns.fixed_names,
        )
