"""Iterative-learning least squares (FCI-LS, paper 002, eq 19-24): rows are repeated, each time with a P-type step."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np

from ....datasets.record import Record
from ....models.model import Model
from ...regression.integrated import Roles, roles
from ...regression.schemes import regression_samples
from ...results.fit import Fit
from ..regression.zero_order_hold import common_step

BETA = 0.005
SHARE = 0.5
"""Share of 2/|phi|^2 that the corrected form limits beta to; a step beyond half of it overshoots.

The bound for convergence is 2/(chi |phi|^2) with chi = 1/(1 + phi'P phi) <= 1.  While P is large this bound lets a
step cancel the least-squares update before it, so the bound for chi = 1 is used throughout.
"""
TOLERANCE, PRINTED_TOLERANCE = 3.0, 1e-3
"""Default tolerances: in standard errors, and in the units of the printed form's coefficients."""


@dataclass(frozen=True)
class LearningRule:
    """The corrected update: gain beta of the P-type step, most repeats of a row, and tolerance in standard errors."""

    beta: float = BETA
    most: int = 200
    tolerance: float = TOLERANCE
    counts: np.ndarray = field(default_factory=lambda: np.zeros(3), repr=False)
    """Repeats, rows and the sum of their squared errors so far; updated in place."""
    plain_covariance: bool = field(default=False, init=False)
    forgetting: float = field(default=1.0, init=False)

    @property
    def repetitions(self) -> float:
        """A row repeated N times counts N times."""
        return float(self.counts[0] / max(self.counts[1], 1.0))

    def run(self, y, h, per_sample: int, theta, factor, diagonal, path) -> None:
        """As `recursion.UpdateRule.run`."""
        from . import _innovation_kernels as kernels

        kernels.iterative_learning(
            y, h, self.beta, SHARE, self.most, self.tolerance, theta, factor, diagonal, path, self.counts
        )


@dataclass(frozen=True)
class PrintedLearning:
    """Options of the printed form; angles and rates in degrees if `degrees`."""

    beta: float
    most: int
    tolerance: float
    p0: float
    degrees: bool


def printed_fit(records: Sequence[Record], model: Model, options: PrintedLearning) -> Fit:
    """The printed form on the difference equation r(t+1) = a1 r(t) + ..., with its columns as they are.

    Raises
    ------
    CannotFit : the model is no response model, or the records have different time steps.
    """
    from . import _innovation_kernels as kernels

    role, dt = roles(model), common_step(records)
    p = len(model.coordinates)
    matrix, offset = paper_columns(role, p, dt)
    unit = _degree_factors(role, model) if options.degrees else np.ones(p)
    degree = np.rad2deg(1.0) if options.degrees else 1.0
    y, phi = _first_equation(records, model)
    columns = phi @ matrix
    target = (dt**role.order * y + columns @ offset) * degree
    columns = np.ascontiguousarray(columns * unit)
    theta, path = np.zeros(p), np.empty_like(columns)
    factor, diagonal = np.eye(p), np.full(p, options.p0)
    repeats = kernels.iterative_learning_as_printed(
        target, columns, options.beta, options.most, options.tolerance, theta, factor, diagonal, path
    )
    back = matrix / dt**role.order
    path = (path * unit / degree - offset) @ back.T
    error = target - columns @ theta
    variance = float(error @ error) / max(len(y) - p, 1) / degree**2 * repeats / len(y)
    half = back @ (factor.T * unit)
    covariance = (half * diagonal) @ half.T * variance
    time = np.arange(len(y)) * dt
    return Fit(path[-1], covariance, n_iterations=repeats, trajectory=path, trajectory_time_s=time)


def _first_equation(records: Sequence[Record], model: Model) -> tuple[np.ndarray, np.ndarray]:
    """y (N,) and phi (N, p) of a response model's one equation, by forward differences."""
    blocks = [block for part in regression_samples(records, model, "forward") for block in part.blocks(model)]
    y, phi = (np.concatenate([block[i][:, 0] for block in blocks]) for i in range(2))
    return y, phi


def _degree_factors(role: Roles, model: Model) -> np.ndarray:
    """Factors (p,) of the columns when angles and rates are changed from radians to degrees."""
    from ....models.simulate import regression

    unit = np.full(len(model.coordinates), np.rad2deg(1.0))
    if role.others:
        rates = np.zeros((2, len(model.regression_states)))
        rates[:, model.regression_states.index("r")] = [1.0, np.rad2deg(1.0)]
        phi = regression(model, rates, np.zeros((2, 1)), np.zeros((2, len(model.regression_inputs))))[1][:, 0]
        unit[role.others] = phi[1, role.others] / phi[0, role.others]
    return unit


def paper_columns(role: Roles, p: int, dt: float) -> tuple[np.ndarray, np.ndarray]:
    """From the model's columns to those of paper 002, eq 3 and 5.

    Returns
    -------
    matrix (p, p) with phi @ matrix the columns r(t), r(t-1), f(r), delta(t), delta(t-1) in the places of the
    coefficients of q, r, f(r), delta_rate and delta (first order: r(t), f(r), delta(t)), and offset (p,): the
    coefficients of an equation without forces.  So theta = dt^order matrix^-1 c + offset.
    """
    matrix, offset = np.eye(p), np.zeros(p)
    for symbol, (i, factor) in role.linear.items():
        matrix[i, i] = 1.0 / factor
        if symbol in ("q", "delta_rate"):
            matrix[i, i] = dt / factor
            base, other = role.linear["r" if symbol == "q" else "delta"]
            matrix[base, i] = 1.0 / other
    if role.order == 2:
        offset[role.linear["q"][0]], offset[role.linear["r"][0]] = 2.0, -1.0
    elif "r" in role.linear:
        offset[role.linear["r"][0]] = 1.0
    return matrix, offset
