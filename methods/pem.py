"""Prediction error: the coefficients whose one-step predictions have the likeliest innovations."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ..datasets.record import Record
from ..estimation.likelihood.linear_problem import NULL
from ..estimation.likelihood.output_error import identify
from ..estimation.methods_only.likelihood.prediction_error import (
    fit_prediction_error,
    information,
    noise_of,
    velocity_estimator,
)
from ..estimation.numerics import factors
from ..estimation.regression.starts import starts_of
from ..estimation.results.fit import Fit
from ..models.errors import CannotFit, FitFailed
from ..models.model import Model
from .base import Method
from .options import option, whole


class Pem(Method):
    """Prediction error with estimated sensor noise and process noise (coloured forces).

    Maximum likelihood for a ship in wind and waves: in addition to the white noise of the sensors, coloured forces (one
    Ornstein-Uhlenbeck process per degree of freedom, with one correlation time) and the noise of the rudder sensor act
    as process noise.  The variances may become zero: then the method is output error that allows for the rudder's
    noise.

    The search starts at the likeliest least-squares solution under strong forces, and lets the forces decrease while
    the coefficients improve.  Predictions over one sample have fewer minima than free runs, but strong forces can also
    hide what the coefficients lack: where the coefficients of `output-error` are likelier than what was found, the
    search goes on from them.

    Records need the rudder and heading or yaw rate; surge and sway are used where the model has them, positions are
    not.  `extra` holds the log likelihood and the noise: `sensor_sd` by state, `force_sd` in N, N and N m (response
    models: rad/s2 of yaw and of its rate) and the forces' `correlation_s`.
    Sources: see `helmbench.estimation.methods_only.likelihood.prediction_error`.
    """

    name = "pem"
    title = "prediction error: likeliest innovations, sensor noise and gusts estimated along"

    max_iterations: int = option(100, "pairs of a coefficient step and a noise step", whole(1))

    def estimate(self, records: Sequence[Record], model: Model) -> Fit:
        starts = [start.coefficients for start in starts_of(records, model)]
        est = velocity_estimator(model.with_coefficients(starts[0]), records)
        p = len(model.coordinates)
        if est.n_values <= p:
            raise CannotFit(f"{est.n_values} measured values for {p} coefficients")
        est, found = fit_prediction_error(est, starts, self.max_iterations, _by_free_runs(records, model))
        solution = factors.solve(information(est, found.point), NULL)
        notes = [factors.rank_message(solution.rank, p), "" if found.converged else "stopped before convergence"]
        setting = found.point.setting
        return Fit(
            setting.vectors[0, :p],
            solution.covariance,
            converged=found.converged,
            message="; ".join(filter(None, notes)),
            n_iterations=found.n_iterations,
            extra={"log_likelihood": found.log_likelihood, **noise_of(est, setting)},
        )


def _by_free_runs(records: Sequence[Record], model: Model) -> np.ndarray | None:
    """Coefficients (p,) by output error; None where it finds none."""
    try:
        outcome = identify(records, model)
        return outcome.problem.coefficients(outcome.minimum.z)
    except (CannotFit, FitFailed):
        return None
