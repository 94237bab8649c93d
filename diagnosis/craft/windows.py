"""Windows of records: their inputs, their start, what was measured in them, and predictions of all of them at once.

A window starts from the yaw rate and heading that the record itself, smoothed, has there, and is predicted with the
recorded inputs for a few ship lengths.  What a free run of minutes adds up (trim, wind, current, the first error) does
not reach its end.  This is for yaw alone and structures that are unknown: where a model is given, free runs
(`diagnosis/free_runs`) know more, for every state and for thrust.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from ...datasets.columns import TWIN
from ...datasets.instruments import felt_rudder
from ...datasets.signals import bridged, lagged, sensor_sd
from ...estimation.observers.smoothing import smoothed_states
from ...estimation.records.gaps import SHORTEST, parts_of
from ...estimation.records.series import inputs_of, samples, speed_of, yaw_rate_of
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
    """The craft's own units: its time T0 = L/U [s] as a hard turn shows it, yaw rate [rad/s] and rudder or command
    [rad] of hard manoeuvres (95 % of all samples are below), speed [m/s] and revolutions [1/s] at which the way is made
    (means over it, so that a time at rest does not count), nan where they are not known; sampling step [s], mean square
    of the measured wind [m2/s2] and a large sum of two thrusts [N], nan or zero where they were not measured."""

    time_s: float
    rate: float
    rudder: float
    speed: float
    turns: float
    step_s: float
    wind2: float
    thrust: float

    @property
    def gain(self) -> float:
        """Yaw acceleration per rudder or command, 1/s2."""
        return self.rate / self.rudder / self.time_s

    @property
    def moment(self) -> float:
        """Yaw acceleration of a hard manoeuvre, rad/s2."""
        return self.rate / self.time_s


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
    """A piece on the grid of the windows: times (M,), inputs (M, nu), which are means over a step, measured and
    smoothed motion (M, 2), the first samples (w,) of its windows, and the place of the first one among all windows."""

    piece: Piece
    grid_s: np.ndarray
    inputs: np.ndarray
    measured: np.ndarray
    smooth: np.ndarray
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
        return sum(_duration(s.piece) for s in self.stretches)

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
        own = dict(zip(self.model.coordinates, sets[0].tolist(), strict=True))
        places = range(len(self.inputs))[lane.windows]
        for number, stretch in enumerate(self.stretches if lane.linkage or own.get(LEAD) else ()):
            firsts, place = stretch.firsts, stretch.place
            first, last = max(places.start, place), min(places.stop, place + firsts.size)
            if first < last:
                rows, at = slice(first - places.start, last - places.start), firsts[first - place : last - place]
                acting = self._acting(number, lane.linkage)
                inputs[rows, :, 0] = acting[at[:, None] + np.arange(inputs.shape[1])]
                if own.get(LEAD):
                    start[rows, self.model.states.index(LAGGED)] = lagged(acting, own[LAG], self.dt)[at]
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


def scales_of(records: Sequence[Record]) -> Scales:
    """The craft's own units, from what the records show.

    Raises
    ------
    CannotFit : the records hold no yaw motion or no movement of the rudder.
    """
    rate, rudder = _high(records, yaw_rate_of), _high(records, lambda r: r.rudder() - np.nanmedian(r.rudder()))
    if not (rate > 0.0 and rudder > 0.0):
        raise CannotFit("the records hold no yaw motion, or the rudder or command never moves")
    wind, step_s = _known(records, wind_speed_of), float(np.median([r.dt for r in records]))
    ways = (_over_the_way(_known(records, of)) for of in (known_speed_of, turns_of))
    thrust = _high(records, thrust_of)
    return Scales(TURN / rate, rate, rudder, *ways, step_s, float(np.mean(wind**2)) if wind.size else 0.0, thrust)


Channel = Callable[["Record"], np.ndarray | None]
"""Samples (N,) of a record; None where it has none."""


def known_speed_of(record: Record) -> np.ndarray | None:
    """Speed (N,); None where it is not known in half of the samples."""
    try:
        speed = speed_of(record)
    except CannotFit:
        return None
    return speed if np.isfinite(speed).mean() > 0.5 else None


def turns_of(record: Record) -> np.ndarray | None:
    """Revolutions of the propeller (N,)."""
    return samples(record, "n")


def wind_speed_of(record: Record) -> np.ndarray | None:
    """Speed of the wind (N,) where its direction is known, too."""
    return record.column("wind_speed_m_s") if record.has("wind_speed_m_s", "wind_direction_rad") else None


def thrust_of(record: Record) -> np.ndarray | None:
    """Sum of the thrusts (N,) of two propellers."""
    return record.column(TWIN[0]) + record.column(TWIN[1]) if record.has(*TWIN) else None


def _known(records: Sequence[Record], of: Channel) -> np.ndarray:
    """Sizes of all samples of records that are no gaps."""
    every = np.abs(np.concatenate([np.zeros(0), *(x for r in records if (x := of(r)) is not None)]))
    return every[np.isfinite(every)]


def _high(records: Sequence[Record], of: Channel) -> float:
    known = _known(records, of)
    return float(np.quantile(known, 0.95)) if np.any(known > 0.0) else float("nan")


def _over_the_way(known: np.ndarray) -> float:
    return float(known @ known / known.sum()) if np.any(known > 0.0) else float("nan")


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
    step, count, stride = _cut(pieces, scales, overlap)
    blocks = max(1, round(sum(map(_duration, pieces)) / BLOCKS / step))
    columns = [model.states.index(s) for s in SYMBOLS]
    parts, stretches, done, place = [], [], 0, 0
    for piece in pieces:
        stretch = _stretch(piece, model, step, count, stride, place)
        firsts = stretch.firsts
        if not firsts.size:
            continue
        places, start = firsts[:, None] + np.arange(count + 1), np.zeros((firsts.size, len(model.states)))
        start[:, columns] = stretch.smooth[firsts]
        owner, block = np.full(firsts.size, piece.owner), done + np.unique(firsts // blocks, return_inverse=True)[1]
        parts.append((stretch.inputs[places], start, stretch.measured[places], owner, block))
        stretches.append(stretch)
        done, place = int(block[-1]) + 1, place + firsts.size
    if not parts:
        raise CannotFit(f"no record has a stretch of {step * count:.3g} s")
    inputs, start, measured, record, block = (np.concatenate(one) for one in zip(*parts, strict=True))
    own = [[sensor_sd(samples_of) for samples_of in _channels(p.record).T] for p in pieces]
    spread = measured - start[:, None, columns]
    spread[:, :, 0] = measured[:, :, 0]
    motion = np.sqrt(mean_of_known(spread**2, (0, 1)))
    motion = np.maximum(np.where(np.isfinite(motion), motion, 1.0), 1e-12)
    noise = np.fmin(np.sqrt(np.mean(np.square(own), axis=0)), NOISE * motion)
    return Windows(model, step, inputs, start, measured, record, block, noise, motion, tuple(stretches))


def _cut(pieces: Sequence[Piece], scales: Scales, overlap: int | None) -> tuple[float, int, int]:
    """Step [s] of the windows, their number of steps, and steps from one to the next."""
    dt, longest = float(np.median([p.record.dt for p in pieces])), max(map(_duration, pieces))
    length = min(max(LENGTH * scales.time_s, FEWEST * dt), max(longest / 3.0, FEWEST * dt))
    step = dt * max(1, int(np.ceil(length / dt / MOST)))
    count = max(FEWEST - 1, round(length / step))
    total = sum(max(_duration(p) / step - count, 0.0) for p in pieces)
    return step, count, max(count // overlap if overlap else max(int(np.ceil(total / WINDOWS)), count // 3), 1)


def _duration(piece: Piece) -> float:
    return float(piece.record.time_s[-1] - piece.record.time_s[0])


def _stretch(piece: Piece, model: Model, step: float, count: int, stride: int, place: int) -> Stretch:
    record, time = piece.record, piece.record.time_s
    given, grid = inputs_of(record, model), time[0] + step * np.arange(int((time[-1] - time[0]) / step + 1e-9) + 1)
    inputs = np.column_stack([_means(time, bridged(given[s], time), grid, step) for s in model.inputs])
    measured = np.column_stack([_nearest(time, values, grid, record.dt) for values in _channels(record).T])
    smooth = np.column_stack([np.interp(grid, time, values) for values in piece.smooth.T])
    return Stretch(piece, grid, inputs, measured, smooth, np.arange(0, len(grid) - count, stride), place)


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
