"""FCI-LS: recursive least squares with iterative learning and a P-type step (paper 002), corrected and as printed."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, ClassVar

import numpy as np

from ..models.errors import BadInput
from .base import CannotFit, Estimate, Fit
from .regression import differences
from .rls import Rls, Setting
from .schemes_integral import Roles, roles
from .tuning.space import Real
from .zoh import common_step

if TYPE_CHECKING:
    from ..datasets.record import Record
    from ..models.model import Model

SHARE = 0.5
"""Share of 2/|phi|^2 to which the corrected form holds beta; beyond half of it a step overshoots.

The bound for convergence is 2/(chi |phi|^2) with chi = 1/(1 + phi'P phi) <= 1.  While P is large that lets a step undo
what least squares has just done, so the bound for chi = 1 is kept throughout.
"""


BETA = 0.005
TOLERANCE, PRINTED_TOLERANCE = 3.0, 1e-3
"""Tolerances in standard errors, and in the printed form's coefficients."""


@dataclass(frozen=True)
class Learning(Setting):
    """Numbers of the iterative-learning recursion, corrected."""

    beta: float = BETA
    most: int = 200
    tolerance: float = TOLERANCE
    share: float = SHARE
    seen: np.ndarray = field(default_factory=lambda: np.zeros(3))
    """Repeats, rows and the sum of their squared errors so far."""

    def run(self, rows, per_sample: int, theta, state, spread, path) -> None:
        """As `Setting.run`."""
        from . import _kernels_innovation as kernels

        y, h, _ = rows
        kernels.iterative_learning(
            y, h, self.beta, self.share, self.most, self.tolerance, theta, state, spread, path, self.seen
        )

    def times(self) -> float:
        """A row repeated N times counts N times."""
        return float(self.seen[0] / max(self.seen[1], 1.0))


class FciLs(Rls):
    """Fast convergent iterative learning least squares.

    Every row is taken again and again, with a step beta phi e behind each, until the coefficients move by less than
    `tolerance`.  With beta = 0 that is the row's weight times the number of repeats, which grows with the innovation:
    the opposite of a robust method.  Corrected, repeats end within `tolerance` standard errors and the step falls like
    1/k: both serve the first rows, where there is something to be gained, and the estimate goes over into that of
    `rls` as rows come in.  As printed, neither fades, and the estimate is left where the last rows push it.

    Parameters
    ----------
    beta : gain of the P-type step at the first row, in scaled columns; held to 1/|phi|^2 (see `SHARE`).
    most : repeats N_max of a row.
    tolerance : sigma of eq 23: in standard errors (None: 3), as printed in the coefficients' units (None: 1e-3).
    p0, theta0, prior, scheme : as in `rls`.
    degrees : as printed: angles and rates in degrees.
    variant : 'corrected', or 'as_printed': the difference equation r(t+1) = a1 r(t) + ... with its columns as they
        are, P(0) = p0 I, all coefficients zero at first, beta constant and without bound.  Response models only.  It
        diverges for beta above 2/|phi|^2, and in radians the prior kills the cubic term.
    """

    name = "fci-ls"
    title = "iterative-learning recursive least squares (paper 002)"
    variants = ("corrected", "as_printed")
    search_space: ClassVar = {"beta": Real(1e-4, 1.0, log=True), "tolerance": Real(0.1, 10.0, log=True)}

    def __init__(
        self,
        beta: float = BETA,
        most: int = 200,
        tolerance: float | None = None,
        p0: float = 1e6,
        theta0=0.0,
        prior: str = "scaled",
        scheme: str = "forward",
        degrees: bool = False,
        variant: str = "corrected",
    ) -> None:
        super().__init__(p0, theta0, prior, scheme)
        self.beta, self.most, self.tolerance, self.degrees, self.variant = beta, most, tolerance, degrees, variant

    def check_options(self) -> None:
        super().check_options()
        if not self.beta >= 0.0:
            raise BadInput(f"beta is {self.beta!r}, a number >= 0 is needed")
        if not self.most >= 1:
            raise BadInput(f"most is {self.most!r}, a number from 1 on is needed")
        if self.tolerance is not None and not self.tolerance >= 0.0:
            raise BadInput(f"tolerance is {self.tolerance!r}, a number >= 0 is needed")

    def setting(self, p: int) -> Setting:
        tolerance = TOLERANCE if self.tolerance is None else self.tolerance
        return Learning(
            self.p0, self._theta0(p), prior=self.prior, beta=self.beta, most=int(self.most), tolerance=tolerance
        )

    def estimate(self, records: Sequence[Record], model: Model) -> Fit:
        if self.variant == "as_printed":
            return self._as_printed(records, model)
        return super().estimate(records, model)

    def partial_fit(self, chunk: Record, model: Model, scale_with: Sequence[Record] | None = None) -> Estimate | None:
        """As `Rls.partial_fit`; BadInput for the printed variant, which only runs on whole records."""
        if self.variant == "as_printed":
            raise BadInput("the printed variant of fci-ls does not run online")
        return super().partial_fit(chunk, model, scale_with)

    def _as_printed(self, records: Sequence[Record], model: Model) -> Fit:
        from . import _kernels_innovation as kernels

        found, dt = roles(model), common_step(records)
        p = len(model.coordinates)
        turn, offset = paper_columns(found, p, dt)
        unit = self._units(found, model) if self.degrees else np.ones(p)
        rad = np.rad2deg(1.0) if self.degrees else 1.0
        y, phi = self._rows(records, model)
        columns = phi @ turn
        target = (dt**found.order * y + columns @ offset) * rad
        columns = np.ascontiguousarray(columns * unit)
        theta, path = np.zeros(p), np.empty_like(columns)
        tolerance = PRINTED_TOLERANCE if self.tolerance is None else self.tolerance
        lower, spread = np.eye(p), np.full(p, self.p0)
        repeats = kernels.iterative_learning_as_printed(
            target, columns, self.beta, int(self.most), tolerance, theta, lower, spread, path
        )
        back = turn / dt**found.order
        path = (path * unit / rad - offset) @ back.T
        error = target - columns @ theta
        variance = float(error @ error) / max(len(y) - p, 1) / rad**2 * repeats / len(y)
        half = back @ (lower.T * unit)
        covariance = (half * spread) @ half.T * variance
        time = np.arange(len(y)) * dt
        return Fit(path[-1], covariance, n_iterations=repeats, trajectory=path, trajectory_time_s=time)

    def _rows(self, records: Sequence[Record], model: Model) -> tuple[np.ndarray, np.ndarray]:
        if self.scheme != "forward":
            raise CannotFit("the printed form has forward differences")
        blocks = [block for part in differences(records, model, "forward") for block in part.blocks(model)]
        y, phi = (np.concatenate([block[i][:, 0] for block in blocks]) for i in range(2))
        return y, phi

    def _units(self, found: Roles, model: Model) -> np.ndarray:
        """Factors (p,) that the columns take when angles and rates go over to degrees."""
        from ..models.simulate import regression

        unit = np.full(len(model.coordinates), np.rad2deg(1.0))
        if found.others:
            rates = np.zeros((2, len(model.regression_states)))
            rates[:, model.regression_states.index("r")] = [1.0, np.rad2deg(1.0)]
            phi = regression(model, rates, np.zeros((2, 1)), np.zeros((2, len(model.regression_inputs))))[1][:, 0]
            unit[found.others] = phi[1, found.others] / phi[0, found.others]
        return unit


def paper_columns(found: Roles, p: int, dt: float) -> tuple[np.ndarray, np.ndarray]:
    """From the model's columns to those of paper 002, eq 3 and 5.

    Returns
    -------
    turn (p, p) with phi @ turn the columns r(t), r(t-1), f(r), delta(t), delta(t-1) in the places of the coefficients
    of q, r, f(r), delta_rate and delta (first order: r(t), f(r), delta(t)), and offset (p,): the coefficients of an
    equation without forces.  So theta = dt^order turn^-1 c + offset.
    """
    turn, offset = np.eye(p), np.zeros(p)
    for symbol, (i, factor) in found.linear.items():
        turn[i, i] = 1.0 / factor
        if symbol in ("q", "delta_rate"):
            turn[i, i] = dt / factor
            base, other = found.linear["r" if symbol == "q" else "delta"]
            turn[base, i] = 1.0 / other
    if found.order == 2:
        offset[found.linear["q"][0]], offset[found.linear["r"][0]] = 2.0, -1.0
    elif "r" in found.linear:
        offset[found.linear["r"][0]] = 1.0
    return turn, offset
