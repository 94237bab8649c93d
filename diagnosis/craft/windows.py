"""Windows of records: their inputs, their start, what was measured in them, and predictions of all of them at once.

A window starts from the yaw rate and heading that the record itself, smoothed, has there, and is predicted with the
recorded inputs for a few ship lengths.  What a free run of minutes adds up (trim, wind, current, the first error) does
not reach its end.  This is for yaw alone and structures that are unknown: where a model is given, free runs
(`diagnosis/free_runs`) know more, for every state and for thrust.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from functools import cached_property
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from ...datasets.instruments import felt_rudder
from ...datasets.signals import bridged, sensor_sd
from ...estimation.observers.smoothed_states import smoothed_states
from ...estimation.records.gaps import SHORTEST, parts_of
from ...estimation.records.series import inputs_of, samples, yaw_rate_of
from ...models.errors import CannotFit

if TYPE_CHECKING:
    from ...datasets.record import Record
    from ...models.model import Model

SYMBOLS = ("r", "psi")
LAGGED, LEAD, LAG = "lead_state", "lead", "lead_T2"
"""State of a rudder or order behind a lag, its share, and the time of the lag: it starts where the record leads it."""
LENGTH = 4.0
"""Length of a window in the craft's own times."""
FEWEST, MOST = 10, 120
"""Samples of a window."""
WINDOWS = 130
"""Windows at most, of all records together."""
BLOCKS = 16
"""Blocks of time, of all records together, that are left out in turn."""
TURN = 0.6
"""Yaw rate of a hard turn times L/U: a circle of three to four lengths' diameter."""
NOISE = 0.3
"""Largest noise of a sensor in the channel's own motion: what varies more from sample to sample may be motion (of waves
that are sampled once a second), and no error of it counts as none."""
LOST = 30.0
"""Largest error in the channel's own motion that a run which leaves the record counts with."""


class Scales(NamedTuple):
    """The craft's own units: its time L/U [s] as a hard turn shows it, yaw rate [rad/s] and rudder or command [rad] of
    hard manoeuvres (95 % of all samples are below), speed [m/s] and revolutions [1/s] at which the way is made (means
    over it, so that a time at rest does not count), nan where they are not known."""

    time_s: float
    rate: float
    rudder: float
    speed: float
    turns: float


class Piece(NamedTuple):
    """A stretch of a record without long gaps, and its smoothed yaw rate and heading (N, 2)."""

    record: Record
    owner: int
    smooth: np.ndarray


class Lane(NamedTuple):
    """Windows that are predicted alike: coefficients (p,), or (W, p) where windows differ, numbers of the linkage
    between order and hull (`models.instruments`), and the windows' places."""

    coefficients: np.ndarray
    linkage: tuple[tuple[str, float], ...] = ()
    windows: slice = slice(None)


class Stretch(NamedTuple):
    """A piece with times (M,) of the windows' grid, the first samples (w,) of its windows, and the place of the first
    one among all windows."""

    piece: Piece
    grid_s: np.ndarray
    firsts: np.ndarray
    place: int


@dataclass(frozen=True, eq=False)
class Windows:
    """W windows of N + 1 samples: see the module.

    inputs : (W, N + 1, nu) of `model`;  start : (W, n), zero for states that a record does not measure;  measured : (W,
    N + 1, 2) yaw rate and heading, nan = gap;  record, block : (W,) numbers, which do not fall;  noise : (2,) standard
    deviations of the sensors, the smallest errors that count;  motion : (2,) of the yaw rate, and of the heading within
    a window;  stretches : what they are cut from;  kept : what acts along a stretch behind a linkage.
    """

    model: Model
    dt: float
    inputs: np.ndarray
    start: np.ndarray
    measured: np.ndarray
    record: np.ndarray
    block: np.ndarray
    noise: np.ndarray
    motion: np.ndarray
    stretches: tuple[Stretch, ...]
    kept: dict[tuple[int, tuple[tuple[str, float], ...]], np.ndarray] = field(default_factory=dict)

    @property
    def length_s(self) -> float:
        """Length of a window, s."""
        return self.dt * (self.inputs.shape[1] - 1)

    @property
    def duration_s(self) -> float:
        """Of all pieces together, s."""
        return float(sum(s.piece.record.time_s[-1] - s.piece.record.time_s[0] for s in self.stretches))

    @cached_property
    def known(self) -> np.ndarray:
        """Where (W, N + 1, 2) something was measured."""
        return np.isfinite(self.measured)

    def errors(self, lanes: Sequence[Lane]) -> np.ndarray:
        """Predicted minus measured (L, N + 1, 2) of the windows of all lanes in turn; 0 in gaps."""
        from ...models.lanes import open_loops

        inputs, start, sets = (np.concatenate(parts) for parts in zip(*map(self._driven, lanes), strict=True))
        measured = np.concatenate([self.measured[lane.windows] for lane in lanes])
        limit, columns = LOST * self.motion, [self.model.states.index(s) for s in SYMBOLS]
        with np.errstate(all="ignore"):
            states = open_loops(self.model, sets, inputs, self.dt, start)
            found = np.clip(states[:, :, columns] - measured, -limit, limit)
        return np.where(np.isnan(found), np.where(np.isnan(measured), 0.0, limit), found)

    def errors_of(self, model: Model) -> np.ndarray:
        """The same (W, N + 1, 2) by a model of the windows' family with its instruments; nan in gaps."""
        lane = Lane(model.coefficients, tuple(model.instruments.items()))
        return np.where(self.known, self.errors([lane]), np.nan)

    def _driven(self, lane: Lane) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Inputs (L, N + 1, nu), starts (L, n) and coefficients (L, p) of the windows of a lane."""
        inputs, start = self.inputs[lane.windows].copy(), self.start[lane.windows].copy()
        sets = np.broadcast_to(lane.coefficients, (len(self.inputs), lane.coefficients.shape[-1]))[lane.windows]
        own, places = (
            dict(zip(self.model.coordinates, sets[0].tolist(), strict=True)),
            range(len(self.inputs))[lane.windows],
        )
        for number, (_, _, firsts, place) in enumerate(self.stretches if lane.linkage or own.get(LEAD) else ()):
            first, last = max(places.start, place), min(places.stop, place + firsts.size)
            if first < last:
                rows, at = slice(first - places.start, last - places.start), firsts[first - place : last - place]
                acting = self._acting(number, lane.linkage)
                inputs[rows, :, 0] = acting[at[:, None] + np.arange(inputs.shape[1])]
                if own.get(LEAD):
                    late = _lag(acting, self.dt / max(own[LAG], 1e-9))
                    start[rows, self.model.states.index(LAGGED)] = late[at]
        return inputs, start, sets

    def _acting(self, number: int, linkage: tuple[tuple[str, float], ...]) -> np.ndarray:
        """What acts along a stretch (M,) behind a linkage."""
        if (number, linkage) not in self.kept:
            record, grid = self.stretches[number].piece.record, self.stretches[number].grid_s
            acting = bridged(felt_rudder(record.time_s, record.rudder(), dict(linkage)), record.time_s)
            self.kept[number, linkage] = _means(record.time_s, acting, grid, self.dt)
        return self.kept[number, linkage]


def mean_of_known(values: np.ndarray, axis: int | tuple[int, ...]) -> np.ndarray:
    """Mean along axes of the values that are no gaps; nan where there is none."""
    known = np.isfinite(values)
    with np.errstate(all="ignore"):
        return np.where(known, values, 0.0).sum(axis=axis) / known.sum(axis=axis)


def _lag(values: np.ndarray, ratio: float) -> np.ndarray:
    """First-order lag (M,) of a series that is linear between samples; ratio: step over time constant."""
    from scipy.signal import lfilter

    decay = float(np.exp(-ratio))
    slope = (1.0 - decay) / ratio
    drive = np.concatenate([[0.0], (slope - decay) * values[:-1] + (1.0 - slope) * values[1:]])
    drive[0] = values[0]
    return np.asarray(lfilter([1.0], [1.0, -decay], drive), float)


def scales_of(records: Sequence[Record]) -> Scales:
    """The craft's own units, from what the records show.

    Raises
    ------
    CannotFit : the records hold no yaw motion or no movement of the rudder.
    """
    rate = _high([yaw_rate_of(record) for record in records])
    rudder = _high([_centred(record.rudder()) for record in records])
    if not (rate > 0.0 and rudder > 0.0):
        raise CannotFit("the records hold no yaw motion, or the rudder or command never moves")
    speed, turns = (_over_the_way([of(record) for record in records]) for of in (_speed, _turns))
    return Scales(TURN / rate, rate, rudder, speed, turns)


def _known(parts: Sequence[np.ndarray]) -> np.ndarray:
    return np.concatenate([np.abs(part[np.isfinite(part)]) for part in parts])


def _high(parts: Sequence[np.ndarray]) -> float:
    known = _known(parts)
    return float(np.quantile(known, 0.95)) if known.size and np.any(known > 0.0) else float("nan")


def _over_the_way(parts: Sequence[np.ndarray]) -> float:
    known = _known(parts)
    return float(known @ known / known.sum()) if np.any(known > 0.0) else float("nan")


def _centred(values: np.ndarray) -> np.ndarray:
    return values - np.nanmedian(values)


def _speed(record: Record) -> np.ndarray:
    from ...estimation.records.series import speed_of

    try:
        return speed_of(record)
    except CannotFit:
        return np.zeros(0)


def _turns(record: Record) -> np.ndarray:
    turns = samples(record, "n")
    return np.zeros(0) if turns is None else turns


def pieces_of(records: Sequence[Record], scales: Scales) -> list[Piece]:
    """The stretches of records between long gaps that are long enough for a window, with their smoothed motion.

    Raises
    ------
    CannotFit : there is none.
    """
    found = []
    for owner, record in enumerate(records):
        for part in parts_of(record, scales.time_s / 20.0):
            states = smoothed_states(part, part.time_s) if part.n >= SHORTEST else {}
            if "psi" not in states and "r" in states:
                middle = 0.5 * (states["r"][1:] + states["r"][:-1])
                states["psi"] = np.concatenate([[0.0], np.cumsum(middle * np.diff(part.time_s))])
            if {"r", "psi"} <= set(states):
                found.append(Piece(part, owner, np.column_stack([states[s] for s in SYMBOLS])))
    if not found:
        raise CannotFit("no record has a stretch with rudder and heading or yaw rate that is long enough")
    return found


def windows_of(pieces: Sequence[Piece], model: Model, scales: Scales, overlap: int | None = None) -> Windows:
    """The windows of the pieces for a model.

    overlap : windows that begin within one; None: up to three, WINDOWS at most of all records together.

    Raises
    ------
    CannotFit : a record lacks an input of the model, or none is long enough.
    """
    step, samples_each = _grid(pieces, scales)
    stride = max(samples_each // overlap if overlap else _stride(pieces, step, samples_each), 1)
    blocks = max(1, round(sum(p.record.time_s[-1] - p.record.time_s[0] for p in pieces) / BLOCKS / step))
    columns = [model.states.index(s) for s in SYMBOLS]
    parts, stretches, done, place = [], [], 0, 0
    for piece in pieces:
        series = resampled(piece, model, step)
        firsts = np.arange(0, len(series.grid_s) - samples_each, stride)
        if not firsts.size:
            continue
        places = firsts[:, None] + np.arange(samples_each + 1)
        start = np.zeros((firsts.size, len(model.states)))
        start[:, columns] = series.smooth[firsts]
        owner, block = np.full(firsts.size, piece.owner), done + np.unique(firsts // blocks, return_inverse=True)[1]
        parts.append((series.inputs[places], start, series.measured[places], owner, block))
        stretches.append(Stretch(piece, series.grid_s, firsts, place))
        done, place = int(block[-1]) + 1, place + firsts.size
    if not parts:
        raise CannotFit(f"no record has a stretch of {step * samples_each:.3g} s")
    inputs, start, measured, record, block = (np.concatenate(one) for one in zip(*parts, strict=True))
    own = [[sensor_sd(samples_of) for samples_of in _channels(p.record).T] for p in pieces]
    spread = measured - start[:, None, columns]
    spread[:, :, 0] = measured[:, :, 0]
    motion = np.sqrt(mean_of_known(spread**2, (0, 1)))
    motion = np.maximum(np.where(np.isfinite(motion), motion, 1.0), 1e-12)
    noise = np.fmin(np.sqrt(np.mean(np.square(own), axis=0)), NOISE * motion)
    return Windows(model, step, inputs, start, measured, record, block, noise, motion, tuple(stretches))


def _grid(pieces: Sequence[Piece], scales: Scales) -> tuple[float, int]:
    """Step [s] of the windows and their number of steps."""
    dt = float(np.median([p.record.dt for p in pieces]))
    longest = max(float(p.record.time_s[-1] - p.record.time_s[0]) for p in pieces)
    length = min(max(LENGTH * scales.time_s, FEWEST * dt), max(longest / 3.0, FEWEST * dt))
    step = dt * max(1, int(np.ceil(length / dt / MOST)))
    return step, max(FEWEST - 1, round(length / step))


def _stride(pieces: Sequence[Piece], step: float, samples_each: int) -> int:
    total = sum(max((p.record.time_s[-1] - p.record.time_s[0]) / step - samples_each, 0.0) for p in pieces)
    return max(int(np.ceil(total / WINDOWS)), samples_each // 3)


class Resampled(NamedTuple):
    """Times (M,) at equal steps; inputs (M, nu), which are means over a step; measured and smoothed motion (M, 2)."""

    grid_s: np.ndarray
    inputs: np.ndarray
    measured: np.ndarray
    smooth: np.ndarray


def resampled(piece: Piece, model: Model, step: float) -> Resampled:
    """A piece at equal steps."""
    record, time = piece.record, piece.record.time_s
    given, grid = inputs_of(record, model), time[0] + step * np.arange(int((time[-1] - time[0]) / step + 1e-9) + 1)
    inputs = np.column_stack([_means(time, bridged(given[s], time), grid, step) for s in model.inputs])
    measured = np.column_stack([_nearest(time, values, grid, record.dt) for values in _channels(record).T])
    smooth = np.column_stack([np.interp(grid, time, values) for values in piece.smooth.T])
    return Resampled(grid, inputs, measured, smooth)


def _channels(record: Record) -> np.ndarray:
    """Yaw rate and heading (N, 2) as measured, nan where they are not."""
    found = [samples(record, symbol) for symbol in SYMBOLS]
    return np.column_stack([np.full(record.n, np.nan) if one is None else one for one in found])


def _means(time: np.ndarray, values: np.ndarray, grid: np.ndarray, step: float) -> np.ndarray:
    """Means (M,) of a series (N,), linear between its samples, over a step about each time of the grid."""
    if step <= 1.001 * float(np.median(np.diff(time))):
        return np.interp(grid, time, values)
    area = np.concatenate([[0.0], np.cumsum(0.5 * (values[1:] + values[:-1]) * np.diff(time))])
    low, high = (np.clip(grid + side * 0.5 * step, time[0], time[-1]) for side in (-1.0, 1.0))
    return (np.interp(high, time, area) - np.interp(low, time, area)) / np.maximum(high - low, 1e-12)


def _nearest(time: np.ndarray, values: np.ndarray, grid: np.ndarray, dt: float) -> np.ndarray:
    """Values (M,) at times of the grid, linear between neighbours; nan where a neighbour is a gap or far away."""
    right = np.clip(np.searchsorted(time, grid), 1, time.size - 1)
    left = right - 1
    part = np.clip((grid - time[left]) / (time[right] - time[left]), 0.0, 1.0)
    found = (1.0 - part) * values[left] + part * values[right]
    found = np.where(part < 1e-6, values[left], np.where(part > 1.0 - 1e-6, values[right], found))
    return np.where(time[right] - time[left] <= 3.0 * dt, found, np.nan)
