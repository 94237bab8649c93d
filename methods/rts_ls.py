"""Least squares on smoothed states and accelerations."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, ClassVar

import numpy as np

from ..models.errors import BadInput
from .base import CannotFit, Fit, Method
from .filtered import Rows, row_factors, stretches
from .ls import least_squares
from .observers.smoothing import Track, Walk, fitted_walk, memory, smoothed
from .regression import Differences, accelerations
from .series import bridged, inputs_of, noise_floor, require, samples, sensor_sd
from .svf_ls import Filtered, coloured_covariance
from .tuning.space import Real

if TYPE_CHECKING:
    from ..datasets.record import Record
    from ..models.model import Model

EXTRA = (1, 2)
"""States beyond the highest derivative that the regression needs, tried."""
SHORTEST = 16
"""Samples that a stretch without long gaps needs."""


class RtsLs(Method):
    """Records smoothed by a kinematic model, then least squares on the states and accelerations.

    Surge, sway and yaw are each an integrated random walk, whose order and process noise are the likeliest for all
    records together; heading and yaw rate are smoothed as one.  The smoother (Rauch-Tung-Striebel) has no lag, but it
    rounds off; the rudder passes through yaw's smoother too, so that a linear equation of yaw stays exact.

    Parameters
    ----------
    level : factor on the process noise: below 1 smooths more than the likelihood asks for.

    3-DOF models need surge, sway and yaw rate or heading, response models yaw rate or heading.
    """

    name = "rts-ls"
    title = "least squares on states and accelerations smoothed by a kinematic model (RTS)"
    search_space: ClassVar = {"level": Real(1e-3, 1e3, log=True)}

    def __init__(self, level: float = 1.0) -> None:
        self.level = level

    def check_options(self) -> None:
        super().check_options()
        if not self.level > 0.0:
            raise BadInput(f"level is {self.level!r}, a positive number is needed")

    def estimate(self, records: Sequence[Record], model: Model) -> Fit:
        pieces = [piece for record in records for piece in _stretches(record, model)]
        if not pieces:
            raise CannotFit("no record has a stretch without long gaps")
        walks = {symbol: self._levelled(_walk(pieces, model, symbol)) for symbol in _symbols(model)}
        rows = [
            Rows(part, np.zeros((len(part.time_s), 1)), "all") for part in _smoothed(pieces, model, walks, self.level)
        ]
        n, p = sum(r.parts.accelerations.size for r in rows), len(model.coordinates)
        if n <= p:
            raise CannotFit(f"{n} usable regression rows for {p} coefficients")
        found = least_squares(*row_factors(rows, model))
        slowest = max(memory(walk) for walk in walks.values()) * max(piece.dt for piece in pieces)
        return Fit(
            found.coefficients,
            coloured_covariance(Filtered(1.0 / slowest, rows, found, np.nan), model),
            message="" if found.rank == p else f"the records determine {found.rank} of {p} directions",
            extra={"rank": found.rank, "walks": {s: {"order": w.order, "level": w.level} for s, w in walks.items()}},
        )

    def _levelled(self, walk: Walk) -> Walk:
        return walk._replace(level=self.level * walk.level)


def _symbols(model: Model) -> list[str]:
    """Motions that are smoothed, yaw under the name of r."""
    if unknown := [s for s in model.regression_states if s not in ("q", "r", "psi", "u", "v", "x", "y")]:
        raise CannotFit(f"model {model.id} has the state {unknown[0]!r}, for which records have no channel")
    return [s for s in ("u", "v", "r") if s in model.regression_states]


def _sensors(record: Record, symbol: str) -> dict[str, np.ndarray]:
    """Channels (N,) of a motion: for yaw, of heading and yaw rate those that the record has."""
    if symbol != "r":
        return {symbol: require(record, symbol)}
    found = {s: v for s in ("psi", "r") if (v := samples(record, s)) is not None and np.isfinite(v).sum() > 1}
    if not found:
        raise CannotFit(f"record {record.name} has no usable yaw rate or heading")
    return found


def _stretches(record: Record, model: Model) -> list[Record]:
    """Pieces of a record at equal time steps without long gaps of what the regression needs."""
    motions = [v for symbol in _symbols(model) for v in list(_sensors(record, symbol).values())[-1:]]
    return [
        _even(piece)
        for piece in stretches(record, [*motions, *inputs_of(record, model).values()])
        if piece.n >= SHORTEST
    ]


def _even(record: Record) -> Record:
    """The record on equal time steps: samples interpolated, gaps kept."""
    if record.uniform():
        return record
    time = record.time_s
    grid = np.arange(time[0], time[-1] + 1e-6 * record.dt, record.dt)
    channels = dict(record.channels)
    if record.has("heading_rad"):
        channels["heading_rad"] = record.heading_unwrapped()
    nearest = np.abs(grid[:, None] - time[np.clip(np.searchsorted(time, grid), 1, len(time) - 1)[:, None] + [-1, 0]])
    far = nearest.min(axis=1) > 0.75 * record.dt
    found = {k: np.where(far, np.nan, np.interp(grid, time, v)) for k, v in channels.items()}
    return type(record)(grid, found, record.name, record.meta)


def _track(record: Record, symbol: str) -> Track:
    channels = _sensors(record, symbol)
    ranks = {"u": 0, "v": 0, "psi": 0, "r": 1}
    columns = [values * record.dt ** ranks[s] for s, values in channels.items()]
    return Track(np.column_stack(columns), tuple(ranks[s] for s in channels))


def _walk(records: Sequence[Record], model: Model, symbol: str) -> Walk:
    """The likeliest random walk of a motion over all records that have the same sensors as most."""
    tracks = [_track(record, symbol) for record in records]
    kinds = [track.ranks for track in tracks]
    common = max(sorted(set(kinds)), key=kinds.count)
    tracks = [track for track in tracks if track.ranks == common]
    columns = [np.concatenate(column) for column in zip(*(list(t.outputs.T) for t in tracks), strict=True)]
    sd = [
        max(np.sqrt(np.mean([sensor_sd(t.outputs[:, c]) ** 2 for t in tracks])), noise_floor(column))
        for c, column in enumerate(columns)
    ]
    highest = _highest(model, symbol)
    return fitted_walk(tracks, np.array(sd) ** 2, [highest + extra for extra in EXTRA])


def _highest(model: Model, symbol: str) -> int:
    """Highest derivative of the motion's first state that the regression needs; yaw's first state is the heading."""
    if symbol != "r":
        return 1
    return 3 if "q" in model.regression_states else 2


def _smoothed(records: Sequence[Record], model: Model, walks: dict[str, Walk], level: float) -> list[Differences]:
    found = []
    for record in records:
        states: dict[str, np.ndarray] = {s: np.zeros(record.n) for s in ("x", "y")}
        slopes: dict[str, np.ndarray] = {}
        for symbol, walk in walks.items():
            track = _track(record, symbol)
            matched = _matched(walk, track, level)
            ranks = smoothed(track, matched) / record.dt ** np.arange(walk.order)
            first = 1 if symbol == "r" else 0
            states[symbol], slopes[symbol] = ranks[:, first], ranks[:, first + 1]
            if symbol == "r":
                states["psi"], states["q"] = ranks[:, 0], ranks[:, 2]
                slopes["q"] = ranks[:, min(3, walk.order - 1)]
                rudder = _rounded(record, model, track, matched)
        found.append(_rows(record, model, states, slopes, rudder))
    return found


def _rounded(record: Record, model: Model, yaw: Track, walk: Walk) -> np.ndarray:
    """Rudder and its slope (N, 2) through yaw's smoother: its integral in the place of the heading."""
    delta = bridged(inputs_of(record, model)["delta"], record.time_s) * record.dt
    integral = np.concatenate([[0.0], np.cumsum((delta[1:] + delta[:-1]) / 2.0)])
    columns = [
        np.where(np.isfinite(y), (integral, delta)[k], np.nan) for y, k in zip(yaw.outputs.T, yaw.ranks, strict=True)
    ]
    ranks = smoothed(Track(np.column_stack(columns), yaw.ranks), walk, like=yaw)
    return ranks[:, 1:3] / record.dt ** np.arange(1, 3)


def _matched(walk: Walk, track: Track, level: float) -> Walk:
    """The walk for a record that lacks one of the sensors: theirs alone."""
    if len(track.ranks) == len(walk.noise):
        return walk
    own = fitted_walk([track], np.array([max(sensor_sd(track.outputs[:, 0]), 1e-300) ** 2]), [walk.order])
    return own._replace(level=level * own.level)


def _rows(record: Record, model: Model, states: dict, slopes: dict, rudder: np.ndarray) -> Differences:
    inputs = {k: bridged(v, record.time_s) for k, v in inputs_of(record, model).items()}
    inputs["delta"], inputs["delta_rate"] = rudder.T
    k = accelerations(model)
    x = np.column_stack([states[s] for s in model.regression_states])
    a = np.column_stack([slopes[s] for s in model.regression_states[:k]])
    u = np.column_stack([inputs[s] for s in model.regression_inputs])
    return Differences(x, a, u, record.time_s)
