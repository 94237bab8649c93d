"""Least squares on records that are filtered or smoothed first, without a lag between channels."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ..datasets.record import Record
from ..datasets.signals import bridged, sensor_sd
from ..estimation.methods_only.tuning.space import Integer, Real
from ..estimation.numerics import factors
from ..estimation.observers.smoothing import (
    SHORTEST,
    SmoothedTrack,
    Walk,
    averaging_length,
    fitted_walk,
    sensor_variances,
    smoothed,
)
from ..estimation.records.series import at_equal_steps, inputs_of, require, samples
from ..estimation.regression.filtered import (
    CORNERS,
    ORDER,
    FilteredFit,
    best_corner,
    coloured_covariance,
    fit_filtered,
    stretches,
)
from ..estimation.regression.least_squares import equation_factors, least_squares
from ..estimation.regression.samples import RegressionSamples, check_enough_rows
from ..estimation.results.fit import Fit
from ..models.errors import CannotFit
from ..models.model import Model
from .base import method
from .options import POSITIVE, option, whole


@method("svf-ls", "least squares on state-variable filtered records")
def SvfLs(
    records: Sequence[Record],
    model: Model,
    omega: float | None = option(
        None,
        "corner frequency, rad/s; None takes the one of 11 whose free run follows the training records best",
        POSITIVE,
        Real(1e-2, 30.0, log=True),
    ),
    order: int = option(
        ORDER,
        "number n of poles of the filter; at least the order of the highest derivative (3 for heading records and "
        "second-order response models)",
        whole(3),
        Integer(3, 6),
    ),
) -> Fit:
    """Least squares after a state-variable filter F(s) = omega^n/(s + omega)^n on every channel.

    Response models need yaw rate or heading, and use both where both are measured; 3-DOF models need surge, sway and
    one of them.

    Exact without noise at every corner frequency within the sampling rate.  Noise that the filter leaves in the
    regressors (of heading and rudder) biases the estimate, most where a pole and a zero nearly cancel: for `patrol`
    (T2 .32 s, T3 .18 s) by 30 and 48 % at low noise, and at no corner frequency by less; `iv` and `output-error` have
    no such bias.
    """
    found = best_corner(records, model, order) if omega is None else fit_filtered(records, model, omega, order)
    solution = found.solution
    return Fit(
        solution.coefficients,
        coloured_covariance(found, model),
        converged=not np.isposinf(found.cost),
        message=factors.rank_message(solution.rank, len(model.coordinates)),
        n_iterations=CORNERS if omega is None else 1,
        extra={"omega_rad_s": found.omega, "rank": solution.rank, "condition": solution.condition},
    )


@method("rts-ls", "least squares on states and accelerations smoothed by a kinematic model (RTS)")
def RtsLs(
    records: Sequence[Record],
    model: Model,
    level: float = option(
        1.0,
        "factor on the process noise: below 1 smooths more than the likelihood suggests",
        POSITIVE,
        Real(1e-3, 1e3, log=True),
    ),
) -> Fit:
    """Records smoothed by a kinematic model, then least squares on the states and accelerations.

    Surge, sway and yaw are each an integrated random walk, whose order and process noise have the largest likelihood
    for all records; heading and yaw rate are smoothed as one motion.  The smoother (Rauch-Tung-Striebel) has no lag,
    but it rounds off fast changes; the rudder passes through yaw's smoother too, so a linear equation of yaw stays
    exact.

    3-DOF models need surge, sway and yaw rate or heading, response models yaw rate or heading.
    """
    rows, walks, dt = smoothed_rows(records, model, level)
    found = least_squares(*equation_factors(rows, model))
    slowest = max(averaging_length(walk) for walk in walks.values()) * dt
    return Fit(
        found.coefficients,
        coloured_covariance(FilteredFit(1.0 / slowest, rows, found, np.nan), model),
        message=factors.rank_message(found.rank, len(model.coordinates)),
        extra={"rank": found.rank, "walks": {s: {"order": w.order, "level": w.level} for s, w in walks.items()}},
    )


EXTRA_STATES = (1, 2)
"""States tried in addition to the highest derivative that the regression needs."""


def smoothed_rows(
    records: Sequence[Record], model: Model, level: float = 1.0
) -> tuple[list[RegressionSamples], dict[str, Walk], float]:
    """Rows of every stretch, smoothed by the random walks of largest likelihood, the random walk of each motion by its
    symbol, and the longest time step, s; `level` is a factor on the process noise of the walks."""
    pieces = [piece for record in records for piece in _stretches(record, model)]
    if not pieces:
        raise CannotFit("no record has a stretch without long gaps")
    walks = {symbol: _scaled(_fitted(pieces, model, symbol), level) for symbol in _motions(model)}
    parts = [_smoothed(piece, model, walks, level) for piece in pieces]
    check_enough_rows(sum(part.accelerations.size for part in parts), model)
    return parts, walks, max(piece.dt for piece in pieces)


def _scaled(walk: Walk, level: float) -> Walk:
    return walk._replace(level=level * walk.level)


def _motions(model: Model) -> list[str]:
    """Symbols of the motions that are smoothed; yaw has the symbol r."""
    return [s for s in ("u", "v", "r") if s in model.regression_states]


def _sensors(record: Record, symbol: str) -> dict[str, np.ndarray]:
    """Channels (N,) of a motion; of yaw, heading and yaw rate as far as the record has them."""
    if symbol != "r":
        return {symbol: require(record, symbol)}
    found = {s: v for s in ("psi", "r") if (v := samples(record, s)) is not None and np.isfinite(v).sum() > 1}
    if not found:
        raise CannotFit(f"record {record.name} has no usable yaw rate or heading")
    return found


def _stretches(record: Record, model: Model) -> list[Record]:
    """Pieces of a record at equal time steps, without long gaps in the channels that the regression needs."""
    motions = [v for symbol in _motions(model) for v in list(_sensors(record, symbol).values())[-1:]]
    used = [*motions, *inputs_of(record, model).values()]
    return [at_equal_steps(piece) for piece in stretches(record, used) if piece.n >= SHORTEST]


def _track(record: Record, symbol: str) -> SmoothedTrack:
    """A motion of a record, with time in samples."""
    channels = _sensors(record, symbol)
    ranks = {"u": 0, "v": 0, "psi": 0, "r": 1}
    columns = [values * record.dt ** ranks[s] for s, values in channels.items()]
    return SmoothedTrack(np.column_stack(columns), tuple(ranks[s] for s in channels))


def _fitted(records: Sequence[Record], model: Model, symbol: str) -> Walk:
    """The random walk of largest likelihood of a motion, over all records with the most common set of sensors."""
    tracks = [_track(record, symbol) for record in records]
    kinds = [track.ranks for track in tracks]
    common = max(sorted(set(kinds)), key=kinds.count)
    tracks = [track for track in tracks if track.ranks == common]
    highest = _highest_derivative(model, symbol)
    return fitted_walk(tracks, sensor_variances(tracks), [highest + extra for extra in EXTRA_STATES])


def _highest_derivative(model: Model, symbol: str) -> int:
    """Highest derivative of a motion's first state that the regression needs; yaw's first state is the heading."""
    if symbol != "r":
        return 1
    return 3 if "q" in model.regression_states else 2


def _smoothed(record: Record, model: Model, walks: dict[str, Walk], level: float) -> RegressionSamples:
    """Smoothed states and accelerations of one stretch."""
    states: dict[str, np.ndarray] = {}
    slopes: dict[str, np.ndarray] = {}
    inputs = {k: bridged(v, record.time_s) for k, v in inputs_of(record, model).items()}
    for symbol, walk in walks.items():
        track = _track(record, symbol)
        own = _for_sensors(walk, track, level)
        derivatives = smoothed(track, own) / record.dt ** np.arange(walk.order)
        first = 1 if symbol == "r" else 0
        states[symbol], slopes[symbol] = derivatives[:, first], derivatives[:, first + 1]
        if symbol == "r":
            states["psi"], states["q"] = derivatives[:, 0], derivatives[:, 2]
            slopes["q"] = derivatives[:, min(3, walk.order - 1)]
            inputs["delta"], inputs["delta_rate"] = _smoothed_rudder(record, model, track, own).T
    return RegressionSamples.of(model, states, slopes, inputs, record.time_s)


def _smoothed_rudder(record: Record, model: Model, yaw: SmoothedTrack, walk: Walk) -> np.ndarray:
    """Rudder and its slope (N, 2) through yaw's smoother, the rudder's integral in the place of the heading."""
    delta = bridged(inputs_of(record, model)["delta"], record.time_s) * record.dt
    integral = np.concatenate([[0.0], np.cumsum((delta[1:] + delta[:-1]) / 2.0)])
    columns = [
        np.where(np.isfinite(y), (integral, delta)[k], np.nan) for y, k in zip(yaw.outputs.T, yaw.ranks, strict=True)
    ]
    derivatives = smoothed(SmoothedTrack(np.column_stack(columns), yaw.ranks), walk, like=yaw)
    return derivatives[:, 1:3] / record.dt ** np.arange(1, 3)


def _for_sensors(walk: Walk, track: SmoothedTrack, level: float) -> Walk:
    """The random walk for a record's own sensors: fitted to the record alone where it lacks one of them."""
    if len(track.ranks) == len(walk.noise):
        return walk
    own = fitted_walk([track], np.array([max(sensor_sd(track.outputs[:, 0]), 1e-300) ** 2]), [walk.order])
    return _scaled(own, level)
