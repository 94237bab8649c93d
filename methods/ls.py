"""Batch least squares: by forward differences, or by the scheme or filter that predicts left-out windows best.

Forward differences fit the difference equation r(t+1) = a1 r(t) + ... exactly, but convert its coefficients by the
explicit Euler rule (paper 002, eq 4 and 6).  The scheme 'zoh' takes the exact inverse map: the matrix logarithm of the
sampled system gives the continuous model that has these samples under a held rudder.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np

from ..datasets.record import Record
from ..datasets.signals import sensor_sd
from ..estimation.methods_only.regression.left_out import SVF, Scheme, best_scheme
from ..estimation.numerics import factors
from ..estimation.records.series import steps
from ..estimation.regression.filtered import coloured_covariance, fit_filtered
from ..estimation.regression.integrated import Roles, roles
from ..estimation.regression.least_squares import LeastSquares, fit_by_scheme
from ..estimation.regression.schemes import INTEGRATED, SCHEMES
from ..estimation.results.fit import Fit, mapped
from ..models.errors import CannotFit, FitFailed
from ..models.model import Model
from .base import method
from .options import option, words

DRAWS, SEED = 48, 48
"""Repetitions (a standard error is then uncertain by a tenth), and the seed of their noise."""


@method("ls", "batch least squares (QR), difference scheme or filter by left-out windows")
def Ls(
    records: Sequence[Record],
    model: Model,
    scheme: str | None = option(
        None,
        "a scheme of `helmbench.estimation.regression.schemes` ('forward' is explicit Euler, 'midpoint' the trapezoid "
        "for first-order equations), or 'zoh': forward differences converted by the exact map for a held rudder, for "
        "response models.  None takes the one of 'forward', 'midpoint' and a state-variable filter at 5 corner "
        "frequencies whose fits follow left-out windows of the records best "
        "(`helmbench.estimation.methods_only.regression.left_out`); `extra['scheme']` says which",
        words("difference scheme", (*SCHEMES, "zoh")),
    ),
) -> Fit:
    """Least squares on the model's difference equations, solved by orthogonal decomposition.

    3-DOF models need surge, sway and yaw rate (or heading); response models yaw rate or heading.  Standard errors take
    the equations' errors as independent, except for the integrated schemes, where sensor noise is coloured
    (`replayed_covariance`), and for the filter, which colours it.
    """
    return fit_by(best_scheme(records, model) if scheme is None else Scheme(scheme), records, model)


@method("ls-forward", "batch least squares on forward differences (papers 000, 001, 002)")
def LsForward(records: Sequence[Record], model: Model) -> Fit:
    """Least squares on forward differences (explicit Euler), as papers 000, 001 and 002 have it, in corrected form.

    Exact on records that are made by explicit Euler.  On others every equation is taken at the beginning of a step
    instead of its middle, and sensor noise at that sample enters both sides: from a 20/20 zigzag of `response-1` with
    medium noise the time constant comes out as 31 to 69 s instead of 13.5 s.  `ls` chooses its scheme.
    """
    return fit_by(Scheme("forward"), records, model)


def fit_by(scheme: Scheme, records: Sequence[Record], model: Model) -> Fit:
    """Least squares on records by a scheme, with the standard errors that its noise asks for."""
    if scheme.name == SVF:
        filtered = fit_filtered(records, model, scheme.omega)
        return _fit(filtered.solution, coloured_covariance(filtered, model), scheme)
    if scheme.name == "zoh":
        found = fit_by_scheme(records, model, "forward")
        exact, covariance = exact_with_covariance(found.coefficients, found.covariance, model, common_step(records))
        return _fit(found._replace(coefficients=exact), covariance, scheme)
    found = fit_by_scheme(records, model, scheme.name)
    if scheme.name in INTEGRATED and found.rank == len(model.coordinates):
        covariance = replayed_covariance(records, lambda r: fit_by_scheme(r, model, scheme.name).coefficients)
        return _fit(found, covariance, scheme)
    return _fit(found, found.covariance, scheme)


def _fit(found: LeastSquares, covariance: np.ndarray, scheme: Scheme) -> Fit:
    chosen = {"scheme": scheme.name} | ({"omega_rad_s": scheme.omega} if scheme.name == SVF else {})
    return Fit(
        found.coefficients,
        covariance,
        message=factors.rank_message(found.rank, len(found.coefficients)),
        extra=chosen | {"rank": found.rank, "condition": found.condition, "residual_sd": found.residual_sd.tolist()},
    )


def replayed_covariance(records: Sequence[Record], fit: Callable[[Sequence[Record]], np.ndarray]) -> np.ndarray:
    """Covariance (p, p) of the coefficients (p,) that `fit` gives for records with added sensor noise.

    Each draw adds white noise to every channel, with the standard deviation of its sensor as estimated from third
    differences.  Integrated equations colour the noise, so the covariance of least squares for independent errors
    would be several times too small.  To first order in the noise the result is exact.

    Raises
    ------
    FitFailed : the repetitions give no finite coefficients.
    """
    rng = np.random.default_rng(SEED)
    spreads = [{name: sensor_sd(values) for name, values in record.channels.items()} for record in records]
    found = []
    for _ in range(DRAWS):
        noisier = [_noisier(record, sd, rng) for record, sd in zip(records, spreads, strict=True)]
        try:
            found.append(fit(noisier))
        except (CannotFit, FitFailed):
            continue
    found = [c for c in found if np.isfinite(c).all()]
    if len(found) < 2:
        raise FitFailed("the fit fails on records with added sensor noise: no standard errors")
    return np.atleast_2d(np.cov(np.array(found).T))


def _noisier(record: Record, sd: dict[str, float], rng: np.random.Generator) -> Record:
    noise = {name: s * rng.standard_normal(record.n) for name, s in sd.items() if np.isfinite(s)}
    return record.with_channels(**{name: record.channels[name] + values for name, values in noise.items()})


STEP = 1e-6
"""Relative step of the central differences in the map's Jacobian."""


def common_step(records: Sequence[Record]) -> float:
    """The one time step of all records, s.

    Raises
    ------
    CannotFit : the steps are not equal.
    """
    found = np.concatenate([steps(record)[:1] for record in records])
    if not all(record.uniform() for record in records) or np.ptp(found) > 1e-3 * found[0]:
        raise CannotFit("the zoh map needs equal time steps in all records")
    return float(np.median(found))


def exact(coefficients: np.ndarray, model: Model, dt: float) -> np.ndarray:
    """Coefficients (p,) of the continuous model whose samples obey the Euler difference equation of `coefficients`.

    The rudder is held over the step dt (s).  Terms in functions of the yaw rate keep their static gain.

    Raises
    ------
    CannotFit : the model is no response model.
    FitFailed : a discrete pole lies at or below zero, where no continuous pole belongs to it.
    """
    found = roles(model)
    return _second(coefficients, found, dt) if found.order == 2 else _first(coefficients, found, dt)


def _first(c: np.ndarray, found: Roles, dt: float) -> np.ndarray:
    """r(t+1) = (1 + dt a) r(t) + ...: the logarithm of the pole; the other coefficients in proportion."""
    if "r" not in found.linear:
        return c
    i, factor = found.linear["r"]
    pole = 1.0 + dt * factor * c[i]
    if not pole > 0.0:
        raise FitFailed(f"the discrete pole {pole:.4g} has no logarithm")
    return c if pole == 1.0 else c * np.log(pole) / (pole - 1.0)


def _second(c: np.ndarray, found: Roles, dt: float) -> np.ndarray:
    """Block matrix logarithm of w(t+1) = w + dt (a1 (w + b2 d) + a2 r + b1 d), r(t+1) = r + dt (w + b2 d)."""
    from scipy.linalg import logm

    a1, a2, b1, b2 = (c[i] * factor for i, factor in (found.linear[s] for s in ("q", "r", "delta", "delta_rate")))
    rate = np.array([[a1, a2, a1 * b2 + b1], [1.0, 0.0, b2], [0.0, 0.0, 0.0]])
    sampled = np.eye(3) + dt * rate
    poles = np.linalg.eigvals(sampled[:2, :2])
    if np.any((np.abs(poles.imag) < 1e-12) & (poles.real <= 0.0)):
        raise FitFailed("a discrete pole at or below zero has no logarithm")
    continuous = np.real(np.asarray(logm(sampled))) / dt
    a, b = continuous[:2, :2], continuous[:2, 2]
    trace, determinant = a[0, 0] + a[1, 1], a[0, 0] * a[1, 1] - a[0, 1] * a[1, 0]
    mapped = {"q": trace, "r": -determinant, "delta_rate": b[1], "delta": a[1] @ b - trace * b[1]}
    result = c * (-determinant / a2)
    for symbol, value in mapped.items():
        i, factor = found.linear[symbol]
        result[i] = value / factor
    return result


def exact_with_covariance(
    c: np.ndarray, covariance: np.ndarray, model: Model, dt: float
) -> tuple[np.ndarray, np.ndarray]:
    """`exact` of c (p,), and its covariance (p, p) by the Jacobian of the map (delta method)."""
    jacobian = np.empty((c.size, c.size))
    for j in range(c.size):
        h = STEP * (abs(c[j]) or 1.0)
        move = np.eye(c.size)[j] * h
        jacobian[:, j] = (exact(c + move, model, dt) - exact(c - move, model, dt)) / (2.0 * h)
    found = mapped(jacobian, covariance)
    return exact(c, model, dt), (found + found.T) / 2.0
