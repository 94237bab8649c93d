"""Recursive least squares: plain, with forgetting (paper 000), and with several innovations at once (paper 004)."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ..estimation.methods_only.recursive.recursion import LeastSquaresRule, UpdateRule
from ..estimation.methods_only.tuning.space import Integer, Real
from ..estimation.regression.samples import RegressionSamples
from .base import RecursiveMethod, method
from .options import POSITIVE, SHARE, number, option, whole

SEARCHED_PRIOR = option(searched=Real(1e-2, 1e12, log=True))
"""`p0`, tuned."""


@method("rls", "recursive least squares", RecursiveMethod, p0=SEARCHED_PRIOR)
def Rls(parts: Sequence[RegressionSamples]) -> UpdateRule:
    """Plain recursive least squares."""
    return LeastSquaresRule()


@method(
    "fw-rls",
    "recursive least squares with forgetting and weighting (paper 000)",
    RecursiveMethod,
    variants=("corrected", "as_printed"),
)
def FwRls(
    parts: Sequence[RegressionSamples],
    mu: float = option(0.999, "forgetting factor of one sample", SHARE, Real(0.95, 1.0)),
    weight: float = option(
        20.0,
        "the constant weight L(k).  It acts only as p0 -> weight p0, that is as a weaker prior",
        POSITIVE,
        Real(1e-2, 1e4, log=True),
    ),
    variant: str = option(
        "corrected",
        "'corrected', or 'as_printed': eq 22 literally, which forgets the information but not the data and does not "
        "converge",
    ),
) -> UpdateRule:
    """Weighted recursive least squares with forgetting on the model's difference equations."""
    return LeastSquaresRule(mu, weight, as_printed=variant == "as_printed")


@method("mi-rls", "multi-innovation recursive least squares (paper 004)", RecursiveMethod, p0=SEARCHED_PRIOR)
def MiRls(
    parts: Sequence[RegressionSamples],
    length: int = option(
        10,
        "samples l in the window.  Every row is used l times, so this is rls with an initial P l times as large: only "
        "a weaker prior",
        whole(1),
        Integer(1, 50, log=True),
    ),
) -> UpdateRule:
    """Multi-innovation recursive least squares: the last l innovations are used at once (paper 004, eq 20)."""
    return MultiInnovationRule(length)


@method(
    "nmi-rls",
    "nonlinear multi-innovation recursive least squares (paper 004)",
    RecursiveMethod,
    variants=("corrected", "as_printed"),
    p0=1e6,
)
def NmiRls(
    parts: Sequence[RegressionSamples],
    omega: float = option(
        1.0,
        "in z = sin(omega e)/omega, omega e limited to +-pi/2, where e is the error of the state predicted one sample "
        "ahead, in units of the state's root mean square.  Large innovations lose weight; towards 0 it is `mi-rls`, "
        "and at 1 nearly so",
        number("a positive number (0 would be mi-rls)", lambda value: value > 0.0),
        Real(0.03, 10.0, log=True),
    ),
    length: int = option(10, "samples in the window, as in `mi-rls`", whole(1), Integer(1, 50, log=True)),
    variant: str = option(
        "corrected",
        "'corrected', or 'as_printed': z = sin(omega e) of innovations in units of the left side's root mean square, "
        "and eq 23 with the plus sign that makes P grow; it diverges",
    ),
) -> UpdateRule:
    """Nonlinear multi-innovation recursive least squares: innovations pass through a sine (paper 004)."""
    if variant == "as_printed":
        return MultiInnovationRule(length, (omega,), as_printed=True)
    return MultiInnovationRule(length, tuple(omega * one_step_share(parts)))


class MultiInnovationRule(UpdateRule):
    """A window of `length` samples, and omega of the sine for each equation (paper 004, eq 20-23).

    Without omega the innovations are taken as they are; as printed, one omega serves all equations.  The rule keeps
    the rows of the last samples: windows reach back over the ends of blocks and records.
    """

    def __init__(self, length: int, omega: tuple[float, ...] = (), as_printed: bool = False) -> None:
        self.length, self.omega = length, omega
        self.repetitions, self.plain_covariance = float(length), as_printed  # every row is in `length` windows
        self.window: tuple[np.ndarray, np.ndarray] | None = None
        """Rows (y, h) of the last length - 1 samples, which the next window still needs."""

    def run(self, y, h, per_sample: int, theta, factor, diagonal, path) -> None:
        first = 0
        if self.window is not None:
            first = len(self.window[0])
            y, h = np.concatenate([self.window[0], y]), np.concatenate([self.window[1], h])
        if self.plain_covariance:
            self._run_as_printed(y, h, first, per_sample, theta, factor, path)
        else:
            from ..estimation.methods_only.recursive._kernels import multi_innovation

            omegas = np.array(self.omega, float)
            if omegas.size not in (0, per_sample):  # an equation without unknowns has been left out
                omegas = np.full(per_sample, omegas.max())
            multi_innovation(y, h, first, per_sample, self.length, omegas, theta, factor, diagonal, path)
        kept = min((self.length - 1) * per_sample, len(y))
        self.window = y[len(y) - kept :].copy(), h[len(y) - kept :].copy()

    def _run_as_printed(self, y, h, first: int, per_sample: int, theta, p, path) -> None:
        """Eq 22 and 23 of paper 004 literally: z = sin(omega E), and P + P Phi (I + Phi'P Phi)^-1 Phi'P."""
        for end in range(first + per_sample, len(y) + 1, per_sample):
            window = slice(max(0, end - self.length * per_sample), end)
            phi = h[window]
            z, projected = np.sin(self.omega[0] * (y[window] - phi @ theta)), phi @ p
            p += projected.T @ np.linalg.solve(np.eye(len(z)) + projected @ phi.T, projected)
            theta += p @ (phi.T @ z)
            path[end - per_sample - first : end - first] = theta


def one_step_share(parts: Sequence[RegressionSamples]) -> np.ndarray:
    """Root mean square (k,) of the change of each differentiated state over one sample, relative to the state's."""
    k = parts[0].accelerations.shape[1]
    change, size = np.zeros(k), np.zeros(k)
    for part in parts:
        if len(part.time_s) > 1:
            dt = float(np.median(np.diff(part.time_s)))
            change += ((part.accelerations * dt) ** 2).sum(axis=0)
            size += (part.states[:, :k] ** 2).sum(axis=0)
    return np.sqrt(np.maximum(change, 1e-300) / np.maximum(size, 1e-300))
