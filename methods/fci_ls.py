"""FCI-LS: recursive least squares with iterative learning and a P-type step (paper 002), corrected and as printed."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ..datasets.record import Record
from ..estimation.methods_only.recursive.recursion import UpdateRule
from ..estimation.methods_only.tuning.space import Real
from ..estimation.regression.integrated import Roles, roles
from ..estimation.regression.samples import RegressionSamples
from ..estimation.regression.schemes import regression_samples
from ..estimation.results.fit import Fit
from ..models.errors import CannotFit
from ..models.model import Model
from .base import RecursiveMethod
from .ls import common_step
from .options import NOT_NEGATIVE, option, whole

SHARE = 0.5
"""Share of 2/|phi|^2 that the corrected form limits beta to; a step beyond half of it overshoots.

The bound for convergence is 2/(chi |phi|^2) with chi = 1/(1 + phi'P phi) <= 1.  While P is large this bound lets a
step cancel the least-squares update before it, so the bound for chi = 1 is used throughout.
"""
TOLERANCE, PRINTED_TOLERANCE = 3.0, 1e-3
"""Default tolerances: in standard errors, and in the units of the printed form's coefficients."""


class FciLs(RecursiveMethod):
    """Fast convergent iterative learning least squares.

    Every row is used several times, each time followed by a step beta phi e, until the coefficients change by less
    than `tolerance`.  With beta = 0 this weights the row by the number of repeats, which grows with the innovation:
    the opposite of a robust method.  Corrected, the repeats end within `tolerance` standard errors and the step falls
    like 1/k.  Both matter for the first rows only, where there is something to gain; as rows come in, the estimate
    becomes that of `rls`.  As printed, neither decreases, and the last rows decide the estimate.
    """

    name = "fci-ls"
    title = "iterative-learning recursive least squares (paper 002)"
    variants = ("corrected", "as_printed")
    beta: float = option(
        0.005,
        "gain of the P-type step at the first row, in scaled columns; limited to 1/|phi|^2",
        NOT_NEGATIVE,
        Real(1e-4, 1.0, log=True),
    )
    most: int = option(200, "most repeats N_max of a row", whole(1))
    tolerance: float | None = option(
        None,
        "sigma of eq 23: in standard errors (None: 3), as printed in the coefficients' units (None: 1e-3)",
        NOT_NEGATIVE,
        Real(0.1, 10.0, log=True),
    )
    p0 = 1e6
    degrees: bool = option(False, "as printed: angles and rates in degrees")
    variant: str = option(
        "corrected",
        "'corrected', or 'as_printed': the difference equation r(t+1) = a1 r(t) + ... with its columns as they are, "
        "P(0) = p0 I, all coefficients zero at first, beta constant and without bound.  Response models only.  It "
        "diverges for beta above 2/|phi|^2, and in radians the prior suppresses the cubic term",
    )

    def update_rule(self, parts: Sequence[RegressionSamples]) -> UpdateRule:
        return LearningRule(self.beta, self.most, TOLERANCE if self.tolerance is None else self.tolerance)

    def estimate(self, records: Sequence[Record], model: Model) -> Fit:
        if self.variant == "corrected":
            return super().estimate(records, model)
        if self.scheme not in (None, "forward"):
            raise CannotFit("the printed form has forward differences")
        return self._as_printed(records, model)

    def _as_printed(self, records: Sequence[Record], model: Model) -> Fit:
        """The printed form on the difference equation r(t+1) = a1 r(t) + ..., with its columns as they are."""
        from ..estimation.methods_only.recursive import _kernels as kernels

        role, dt = roles(model), common_step(records)
        p = len(model.coordinates)
        matrix, offset = paper_columns(role, p, dt)
        unit = _degree_factors(role, model) if self.degrees else np.ones(p)
        degree = np.rad2deg(1.0) if self.degrees else 1.0
        y, phi = _first_equation(records, model)
        columns = phi @ matrix
        target = (dt**role.order * y + columns @ offset) * degree
        columns = np.ascontiguousarray(columns * unit)
        theta, path = np.zeros(p), np.empty_like(columns)
        factor, diagonal = np.eye(p), np.full(p, self.p0)
        tolerance = PRINTED_TOLERANCE if self.tolerance is None else self.tolerance
        repeats = kernels.iterative_learning_as_printed(
            target, columns, self.beta, self.most, tolerance, theta, factor, diagonal, path
        )
        back = matrix / dt**role.order
        path = (path * unit / degree - offset) @ back.T
        error = target - columns @ theta
        variance = float(error @ error) / max(len(y) - p, 1) / degree**2 * repeats / len(y)
        half = back @ (factor.T * unit)
        covariance = (half * diagonal) @ half.T * variance
        time = np.arange(len(y)) * dt
        return Fit(path[-1], covariance, n_iterations=repeats, trajectory=path, trajectory_time_s=time)


class LearningRule(UpdateRule):
    """The corrected update: gain beta of the P-type step, most repeats of a row, and tolerance in standard errors."""

    def __init__(self, beta: float, most: int, tolerance: float) -> None:
        self.beta, self.most, self.tolerance = beta, most, tolerance
        self.counts = np.zeros(3)  # repeats, rows and the sum of their squared errors so far

    def run(self, y, h, per_sample: int, theta, factor, diagonal, path) -> None:
        from ..estimation.methods_only.recursive import _kernels as kernels

        kernels.iterative_learning(
            y, h, self.beta, SHARE, self.most, self.tolerance, theta, factor, diagonal, path, self.counts
        )
        self.repetitions = float(self.counts[0] / max(self.counts[1], 1.0))  # a row repeated N times counts N times


def _first_equation(records: Sequence[Record], model: Model) -> tuple[np.ndarray, np.ndarray]:
    """y (N,) and phi (N, p) of a response model's one equation, by forward differences."""
    blocks = [block for part in regression_samples(records, model, "forward") for block in part.blocks(model)]
    y, phi = (np.concatenate([block[i][:, 0] for block in blocks]) for i in range(2))
    return y, phi


def _degree_factors(role: Roles, model: Model) -> np.ndarray:
    """Factors (p,) of the columns when angles and rates are changed from radians to degrees."""
    from ..models.simulate import regression

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
