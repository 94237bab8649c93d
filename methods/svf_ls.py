"""Least squares on state-variable filtered records: the remedy for paper 003's lagging observer."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, ClassVar, NamedTuple

import numpy as np

from ..models.errors import BadInput
from .base import CannotFit, Fit, FitFailed, Method
from .filtered import ORDER, Rows, filtered_rows, row_factors
from .ls import LeastSquares, least_squares
from .regression import accelerations
from .selection import free_run_cost
from .series import series_of
from .tuning.space import Integer, Real

if TYPE_CHECKING:
    from ..datasets.record import Record
    from ..models.model import Model

CORNERS = 11
"""Corner frequencies tried."""
FASTEST, SLOWEST = 1.0, 60.0
"""omega dt of the fastest corner tried, and time constants of the slowest in the longest record."""
BLOCK_TIME = 20.0
"""Length, in time constants of the filter, of the blocks of rows whose errors count as independent."""


class Filtered(NamedTuple):
    """Least squares at one corner frequency; `cost` ranks it (smaller is better)."""

    omega: float
    rows: list[Rows]
    solution: LeastSquares
    cost: float


def corner_frequencies(records: Sequence[Record], count: int = CORNERS) -> np.ndarray:
    """Corner frequencies (count,), rad/s, from the slowest that the longest record bears to the sampling's."""
    dt = max(record.dt for record in records)
    length = max(record.time_s[-1] - record.time_s[0] for record in records)
    return np.geomspace(min(SLOWEST / length, FASTEST / dt), FASTEST / dt, count)


def fit_filtered(
    records: Sequence[Record], model: Model, omega: float, order: int = ORDER
) -> tuple[list[Rows], LeastSquares]:
    """Rows and least squares at a corner frequency omega [rad/s]; raises as `SvfLs`."""
    rows = filtered_rows(records, model, omega, order)
    return rows, least_squares(*row_factors(rows, model))


def best_corner(records: Sequence[Record], model: Model, corners: Sequence[float], order: int = ORDER) -> Filtered:
    """The corner frequency whose estimate follows the training records best in free run.

    Raises
    ------
    CannotFit : none of them can be fitted.
    """
    found, reason = [], "no corner frequency gives an estimate"
    series = [series_of(record, model) for record in records]
    for omega in corners:
        try:
            rows, solution = fit_filtered(records, model, float(omega), order)
        except (CannotFit, FitFailed) as error:
            reason = error.reason
            continue
        cost = free_run_cost(model.with_coefficients(solution.coefficients), series)
        found.append(Filtered(float(omega), rows, solution, cost))
    if not found:
        raise CannotFit(reason)
    return min(found, key=lambda f: f.cost) if np.isfinite([f.cost for f in found]).any() else found[len(found) // 2]


def coloured_covariance(found: Filtered, model: Model) -> np.ndarray:
    """Covariance (p, p) of the coefficients that allows for the filter's colouring of the errors (block sandwich).

    The rows' scores are summed over blocks of 20 time constants, which are taken as independent.
    """
    solution = found.solution
    scores = np.vstack([_block_scores(rows, found, model) for rows in found.rows]) @ solution.half
    p = solution.half.shape[1]
    middle = scores.T @ scores * len(scores) / max(len(scores) - p, 1)
    if len(scores) < 10 * p:
        middle = np.eye(p) * max(np.trace(middle) / max(p, 1), 1.0)
    covariance = solution.half @ middle @ solution.half.T
    unknown = ~np.isfinite(np.diag(solution.covariance))
    covariance[unknown, unknown] = np.inf
    return covariance


def _block_scores(rows: Rows, found: Filtered, model: Model) -> np.ndarray:
    """Sums (B, p) of Phi' e/sd^2 over blocks of rows."""
    k = accelerations(model)
    sources = sorted({r.source for r in found.rows})
    sd = _per_equation(found.solution.residual_sd, sources.index(rows.source), k)
    scores = []
    for y, phi in rows.blocks(model):
        error = (y - phi @ found.solution.coefficients) / sd**2
        scores.append(np.einsum("nkp,nk->np", phi, error))
    block = ((rows.parts.time_s - rows.parts.time_s[0]) * found.omega / BLOCK_TIME).astype(np.int64)
    total = np.zeros((block[-1] + 1 if len(block) else 1, phi.shape[2]))
    np.add.at(total, block, np.vstack(scores))
    return total


def _per_equation(sd: np.ndarray, source: int, k: int) -> np.ndarray:
    own = sd[source * k : (source + 1) * k]
    return np.where(np.isfinite(own) & (own > 0.0), own, np.inf)


class SvfLs(Method):
    """Least squares after a state-variable filter F(s) = omega^n/(s + omega)^n on every channel.

    Parameters
    ----------
    omega : corner frequency, rad/s; None takes that of 11 whose free run follows the training records best.
    order : number of poles of the filter; at least the order of the highest derivative (3 for heading records and
        second-order response models).

    Response models need yaw rate or heading, and use both where they are; 3-DOF models surge, sway and one of them.

    Exact without noise at every corner within the sampling rate.  Noise that the filter leaves in the regressors (of
    heading and rudder) biases the estimate, most where a pole and a zero nearly cancel: for `patrol` (T2 .32 s, T3
    .18 s) by 30 and 48 % at low noise, and at no corner by less; `iv` and `output-error` have no such bias.
    """

    name = "svf-ls"
    title = "least squares on state-variable filtered records"
    search_space: ClassVar = {"omega": Real(1e-2, 30.0, log=True), "order": Integer(3, 6)}

    def __init__(self, omega: float | None = None, order: int = ORDER) -> None:
        self.omega, self.order = omega, order

    def check_options(self) -> None:
        super().check_options()
        if self.omega is not None and not self.omega > 0.0:
            raise BadInput(f"omega is {self.omega!r}, a positive number of rad/s is needed")
        if self.order < 3:
            raise BadInput(f"order is {self.order!r}, at least 3 is needed")

    def estimate(self, records: Sequence[Record], model: Model) -> Fit:
        if self.omega is not None:
            rows, solution = fit_filtered(records, model, self.omega, self.order)
            found = Filtered(self.omega, rows, solution, np.nan)
        else:
            found = best_corner(records, model, corner_frequencies(records).tolist(), self.order)
        p, rank = len(model.coordinates), found.solution.rank
        return Fit(
            found.solution.coefficients,
            coloured_covariance(found, model),
            converged=not np.isposinf(found.cost),
            message="" if rank == p else f"the records determine {rank} of {p} directions",
            n_iterations=CORNERS if self.omega is None else 1,
            extra={"omega_rad_s": found.omega, "rank": rank, "condition": found.solution.condition},
        )
