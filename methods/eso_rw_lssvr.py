"""Paper 003's pipeline: extended state observer, then robust weighted LS-SVR on its estimates.

The linear extended state observer of the heading (eq 8-20, corrected; the printed form is separate) has the
states psi, r, psi_ddot and z5, the part of psi_dddot that b0 u does not explain, driven by e = psi - z1:

    z1' = z2 + l1 e,  z2' = z4 + l2 e,  z4' = z5 + b0 u + l4 e,  z5' = l5 e

with characteristic polynomial s^4 + l1 s^3 + l2 s^2 + l4 s + l5.  psi_dddot is estimated by z5 + b0 u.  z5 lags the
heading by 4/omega0, the other states by less; `observers.linear` has a filter with one lag for all derivatives.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..datasets.record import Record
from ..datasets.signals import bridged
from ..estimation.methods_only.tuning.space import Real
from ..estimation.observers.linear import Discrete, discretised, respond
from ..estimation.records.series import inputs_of, require
from ..estimation.regression.filtered import (
    BLOCK_TIME,
    best_corner,
    best_of_corners,
    corner_frequencies,
    filtered_rows,
    stretches,
)
from ..estimation.regression.samples import RegressionSamples, check_enough_rows
from ..estimation.results.fit import Fit
from ..models.errors import CannotFit
from ..models.model import Model
from .base import method
from .ls_svr import CONSTANT, TUNER, Tuner, fit_svr, stacked_rows
from .options import POSITIVE, option, words

PRINTED_OMEGA = 45.0
"""rad/s; Table 3's gains are those of (s + 45)^4."""
PRINTED_L3 = 100.0
METHODS = ("exact", "euler")


@method(
    "eso-rw-lssvr",
    "extended state observer and robust weighted LS-SVR (paper 003)",
    variants=("corrected", "proposed", "as_printed"),
)
def EsoRwLssvr(
    records: Sequence[Record],
    model: Model,
    omega0: float | None = option(
        None,
        "the observer's poles, rad/s; None takes those, of several, whose least-squares estimate follows the training "
        "records best in free run ('as_printed': 45)",
        POSITIVE,
        Real(1e-2, 60.0, log=True),
    ),
    aligned: bool = option(
        True,
        "give every channel the lag of the observer's last state: heading and rudder pass through the filter "
        "omega0^4/(s + omega0)^4 by which z5 estimates psi_dddot.  False takes the observer's states as they are",
    ),
    discretisation: str = option(
        "exact", "'exact' or 'euler' ('as_printed' is always Euler)", words("discretisation", METHODS)
    ),
    b0: float = option(
        0.0, "input gain of the observer, on the rudder; 0 leaves the whole third derivative to be observed"
    ),
    C: float | None = CONSTANT,
    tuner: str | Tuner = TUNER,
    weighted: bool = option(True, "False takes `ls-svr` behind the observer, with which paper 003 compares its own"),
    variant: str = option(
        "corrected",
        "'corrected'; 'proposed': what the paper proposes in corrected equations, with the observer's states as they "
        "are and C by its bee colony, whatever `aligned` and `tuner` say; or 'as_printed': b0 = 1 on the heading "
        "reference, l3 = 100, rudder and rudder slope as the observer has them, signed weights, regularised in SI "
        "units with intercept, fitted to the first 60 %",
    ),
) -> Fit:
    """Heading through an extended state observer, then `rw-ls-svr` on psi_ddot, psi_dot, rudder and its slope.

    Response models, from the heading.  The printed form needs the heading reference, which it takes from the rudder
    command of a vessel with heading controller and rudder lag.  Unless aligned, the observer's derivatives lag behind
    its other states by up to 4/omega0, which biases the estimate; with the noise of any real sensor it does so at
    every omega0.
    """
    if model.is_3dof:
        raise CannotFit(f"the heading observer needs a response model, and {model.family} is none")
    printed, proposed = variant == "as_printed", variant == "proposed"
    if printed:
        omega = PRINTED_OMEGA if omega0 is None else omega0
        parts = printed_samples(records, model, omega)
    elif aligned and not proposed:
        omega, parts = _aligned_rows(records, model, omega0)
    else:
        omega, parts = observed_samples(records, model, omega0, discretisation, b0)
    spacing = float(np.median(np.diff(parts[0].time_s)))
    rows = stacked_rows(parts, model, max(1, int(BLOCK_TIME / omega / spacing)), physical=printed)
    return fit_svr(rows, weighted, printed, C, "abc" if proposed else tuner, {"omega0_rad_s": omega})


def _aligned_rows(
    records: Sequence[Record], model: Model, omega0: float | None
) -> tuple[float, list[RegressionSamples]]:
    """Poles [rad/s] and rows in which all channels have the same lag, from the heading alone."""
    headings = [record.with_channels(yaw_rate_rad_s=None) for record in records]
    for record in headings:
        require(record, "psi")
    if omega0 is not None:
        return omega0, filtered_rows(headings, model, omega0)
    found = best_corner(headings, model)
    return found.omega, found.rows


POLES, SLOWEST = 9, 40.0
"""Poles of the observer tried, and time constants of the slowest one in the longest record."""
TRANSIENT = 8.0
"""Time constants of the observer, from the start of a stretch, that are left out."""
SHORTEST = 16
"""Samples that a stretch without long gaps needs."""


def observed_samples(
    records: Sequence[Record], model: Model, omega0: float | None, discretisation: str = "exact", b0: float = 0.0
) -> tuple[float, list[RegressionSamples]]:
    """Poles omega0 [rad/s] and samples of an observer with input gain b0 on the rudder; None takes those poles whose
    free run follows the records best."""

    def rows_at(omega: float) -> list[RegressionSamples]:
        return _checked(_observed(records, model, omega, discretisation, b0), model)

    if omega0 is not None:
        return omega0, rows_at(omega0)
    found = best_of_corners(corner_frequencies(records, POLES, SLOWEST), rows_at, records, model)
    return found.omega, found.rows


def printed_samples(records: Sequence[Record], model: Model, omega0: float) -> list[RegressionSamples]:
    """Observed samples of eq 8 as printed, with poles omega0 [rad/s]."""
    return _checked([samples for record in records for samples in _printed(record, model, omega0)], model)


def _checked(samples: list[RegressionSamples], model: Model) -> list[RegressionSamples]:
    check_enough_rows(sum(len(part.time_s) for part in samples), model)
    return samples


def _observed(
    records: Sequence[Record], model: Model, omega0: float, discretisation: str, b0: float
) -> list[RegressionSamples]:
    """Samples of every stretch after the observer's transient."""
    found = []
    for record in records:
        for piece in _stretches(record, model):
            psi, rudder, others, time, dt = _on_grid(piece, model)
            states = observe(psi, dt, omega0, discretisation, b0, rudder)
            samples = _samples(states, rudder, np.gradient(rudder, dt), others, time, model)
            found.append(samples.at(slice(int(np.searchsorted(time, time[0] + TRANSIENT / omega0)), None)))
    return [samples for samples in found if len(samples.time_s)]


def _stretches(record: Record, model: Model) -> list[Record]:
    used = [require(record, "psi"), *inputs_of(record, model).values()]
    return [piece for piece in stretches(record, used) if piece.n >= SHORTEST]


def _on_grid(record: Record, model: Model) -> tuple[np.ndarray, np.ndarray, dict[str, np.ndarray], np.ndarray, float]:
    """Heading, rudder, other inputs and times (N,) at equal steps dt."""
    time, dt = record.time_s, record.dt
    grid = time if record.uniform() else np.arange(time[0], time[-1] + 0.5 * dt, dt)
    given = {k: np.interp(grid, time, bridged(v, time)) for k, v in inputs_of(record, model).items()}
    psi = np.interp(grid, time, bridged(require(record, "psi"), time))
    return psi, given.pop("delta"), given, grid, dt


def _samples(
    observed: Observed,
    rudder: np.ndarray,
    slope: np.ndarray,
    others: dict[str, np.ndarray],
    time: np.ndarray,
    model: Model,
) -> RegressionSamples:
    states = {"psi": observed.psi, "r": observed.r, "q": observed.psi_ddot}
    slopes = {"r": observed.psi_ddot, "q": observed.psi_dddot}
    return RegressionSamples.of(model, states, slopes, {"delta": rudder, "delta_rate": slope, **others}, time)


def _printed(record: Record, model: Model, omega0: float) -> list[RegressionSamples]:
    if model.controller is None or not model.rudder.lag_s > 0.0 or not record.has("rudder_command_rad"):
        raise CannotFit("the printed observer needs a vessel with heading controller, rudder lag and a rudder command")
    kp, found = model.controller.kp, []
    for piece in stretches(record, [require(record, "psi"), record.column("rudder_command_rad")]):
        if piece.n < SHORTEST:
            continue
        psi, _, others, time, dt = _on_grid(piece, model)
        command = piece.column("rudder_command_rad")
        reference = psi + np.interp(time, piece.time_s, bridged(command, piece.time_s)) / kp
        observed = observe_as_printed(psi, reference, dt, kp, model.rudder.lag_s, omega0)
        assert observed.delta is not None and observed.delta_dot is not None
        found.append(_samples(observed, observed.delta, observed.delta_dot, others, time, model))
    return found


# ---- The observer.


class Observed(NamedTuple):
    """Estimates (N,) of heading, yaw rate and its two derivatives; rudder and its slope in the printed form."""

    psi: NDArray[np.float64]
    r: NDArray[np.float64]
    psi_ddot: NDArray[np.float64]
    psi_dddot: NDArray[np.float64]
    delta: NDArray[np.float64] | None = None
    delta_dot: NDArray[np.float64] | None = None


def gains(poles: ArrayLike) -> NDArray[np.float64]:
    """l1, l2, l4, l5 (4,) that place the four poles (eq 20; all six pair products in l2).

    Raises
    ------
    ValueError : unless they are four, with negative real parts, and real or in conjugate pairs.
    """
    poles = np.asarray(poles, complex)
    polynomial = np.poly(poles)
    if poles.shape != (4,) or (np.real(poles) >= 0.0).any() or np.abs(np.imag(polynomial)).max() > 0.0:
        raise ValueError("four poles with negative real parts, real or in conjugate pairs, are needed")
    return np.real(polynomial[1:]).astype(float)


def observer(gain: ArrayLike, b0: float = 0.0) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """a (4, 4) and b (4, 2) of the states (psi, r, psi_ddot, z5) driven by (psi, u)."""
    l1, l2, l4, l5 = np.asarray(gain, float)
    a = np.array([[-l1, 1.0, 0.0, 0.0], [-l2, 0.0, 1.0, 0.0], [-l4, 0.0, 0.0, 1.0], [-l5, 0.0, 0.0, 0.0]])
    b = np.array([[l1, 0.0], [l2, 0.0], [l4, b0], [l5, 0.0]])
    return a, b


def sampled_observer(omega0: float, dt: float, method: str = "exact", b0: float = 0.0) -> Discrete:
    """The observer in samples, inputs (psi, u) held.

    Parameters
    ----------
    method : 'exact' (the chain of integrators over dt solved exactly, all poles at exp(-omega0 dt), so stable for every
        omega0), or 'euler' (one explicit step a sample, as the paper computes it).

    Raises
    ------
    ValueError : for another method.
    """
    if method not in METHODS:
        raise ValueError(f"unknown method {method!r}; known: {', '.join(METHODS)}")
    if method == "euler":
        return discretised(*observer(gains([-omega0] * 4), b0), dt, "euler")
    unit = dt ** -np.arange(4.0)  # in units of dt the numbers below do not depend on it
    chain = discretised(np.eye(4, k=1), np.eye(4)[:, 2:3], 1.0, "zero")
    rows = [np.linalg.matrix_power(chain.a, k)[0] for k in range(4)]
    shifted = chain.a - np.exp(-omega0 * dt) * np.eye(4)
    gain = np.linalg.matrix_power(shifted, 4) @ np.linalg.solve(np.array(rows), np.eye(4)[:, 3])  # Ackermann
    a = chain.a - np.outer(gain, np.eye(4)[0])
    now = np.column_stack([gain * unit, chain.now[:, 0] * unit * dt**3 * b0])
    return Discrete(a * unit[:, None] / unit, now, np.zeros((4, 2)))


def printed_observer(
    gain: ArrayLike, l3: float, kp: float, lag_s: float
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """a (5, 5) and b (5, 2) of eq 8 as printed: states (psi, r, rudder, psi_ddot, z5), inputs (psi, heading reference).

    b0 is 1 and the rudder follows the helmsman kp (u - z1) through a lag, corrected by l3 e.
    """
    l1, l2, l4, l5 = np.asarray(gain, float)
    a = np.array(
        [
            [-l1, 1.0, 0.0, 0.0, 0.0],
            [-l2, 0.0, 0.0, 1.0, 0.0],
            [-kp / lag_s - l3, 0.0, -1.0 / lag_s, 0.0, 0.0],
            [-l4, 0.0, 0.0, 0.0, 1.0],
            [-l5, 0.0, 0.0, 0.0, 0.0],
        ]
    )
    b = np.array([[l1, 0.0], [l2, 0.0], [l3, kp / lag_s], [l4, 1.0], [l5, 0.0]])
    return a, b


def observe(
    psi: NDArray[np.float64],
    dt: float,
    omega0: float,
    method: str = "exact",
    b0: float = 0.0,
    u: NDArray[np.float64] | None = None,
) -> Observed:
    """The corrected observer along headings (N,) sampled every dt seconds, started at the first.

    Parameters
    ----------
    omega0 : rad/s; all four poles lie at -omega0.
    method : 'exact' or 'euler', see `sampled_observer`.
    b0, u : gain and samples (N,) of an input that the observer knows.
    """
    u = np.zeros(len(psi)) if u is None else u
    system = sampled_observer(omega0, dt, method, b0)
    z = respond(system, np.column_stack([psi, u]), [psi[0], 0.0, 0.0, -b0 * u[0]])
    return Observed(z[:, 0], z[:, 1], z[:, 2], z[:, 3] + b0 * u)


def observe_as_printed(
    psi: NDArray[np.float64],
    reference: NDArray[np.float64],
    dt: float,
    kp: float,
    lag_s: float,
    omega0: float = PRINTED_OMEGA,
) -> Observed:
    """Eq 8 as printed by explicit Euler, from rest: headings and heading references (N,) sampled every dt seconds.

    The rudder's slope is that of the steering gear at the observer's own states.
    """
    system = discretised(*printed_observer(gains([-omega0] * 4), PRINTED_L3, kp, lag_s), dt, "euler")
    z = respond(system, np.column_stack([psi, reference]), np.zeros(5))
    slope = (kp * (reference - z[:, 0]) - z[:, 2]) / lag_s
    return Observed(z[:, 0], z[:, 1], z[:, 3], z[:, 4] + reference, z[:, 2], slope)
