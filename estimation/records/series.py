"""Records as the arrays that simulation-based methods take.

A `Series` is one record on the equal time grid of the kernels: inputs on the grid, measured outputs with their place
on it, and the initial state and sensor noise as estimated from the record.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from ...datasets.columns import TWIN
from ...datasets.record import Record
from ...datasets.signals import bridged, sensor_sd
from ...models.errors import CannotFit
from ...models.model import Model
from .weather import CURRENT, flow_of, measured_weather

MEASURED = ("u", "v", "r", "psi")
"""States whose channels simulation-based methods fit; positions have no information that these lack."""


def steps(record: Record) -> np.ndarray:
    """Time steps (N - 1,), s; exactly equal where the record's are equal up to rounding."""
    if record.n < 2 or not record.uniform():
        return np.diff(record.time_s)
    return np.full(record.n - 1, (record.time_s[-1] - record.time_s[0]) / (record.n - 1))


def samples(record: Record, symbol: str) -> np.ndarray | None:
    """Channel (N,) of a state or input by its symbol, heading unwrapped, nan where not finite; None if absent."""
    from ...models.model import CHANNELS

    name = CHANNELS.get(symbol)
    if name is None or not record.has(name):
        return None
    values = record.continuous(name)
    return np.where(np.isfinite(values), values, np.nan)


def require(record: Record, symbol: str) -> np.ndarray:
    """As `samples`, for a channel that is needed.

    Raises
    ------
    CannotFit : the record has none, naming both.
    """
    from ...models.model import CHANNELS

    values = samples(record, symbol)
    if values is None:
        raise CannotFit(f"record {record.name} has no column {CHANNELS.get(symbol, symbol)}")
    return values


def inputs_of(record: Record, model: Model) -> dict[str, np.ndarray]:
    """Input samples (N,) by symbol: rudder (measured, else commanded), propeller (else its set value), speed, wind.

    The speed is measured, else that of the positions; the wind's velocity is that towards north and east, m/s.
    """
    rudder = record.rudder()
    found = {"delta": np.where(np.isfinite(rudder), rudder, np.nan)}
    if "n" in model.inputs:
        turns = samples(record, "n")
        if turns is None and model.n0_rps is None:
            raise CannotFit(f"record {record.name} has no column propeller_rps and model {model.id} no set value")
        found["n"] = np.full(record.n, model.n0_rps) if turns is None else turns
    if "speed" in model.inputs:
        found["speed"] = speed_of(record)
    if "thrust_sum" in model.inputs:
        port, starboard = (record.column(name) for name in TWIN)
        found["thrust_sum"] = port + starboard
    if "wind_north" in model.inputs:
        found |= dict(zip(("wind_north", "wind_east"), wind_of(record), strict=True))
    return found


def speed_of(record: Record) -> np.ndarray:
    """Speed through the water (N,), m/s, negative where the craft goes astern.

    It is that of surge and, where it is measured, sway; else that of the positions, whose course against the heading
    shows whether the craft goes astern.  Both are over ground; a measured current is taken off.
    Positions without a heading give the size alone.

    Raises
    ------
    CannotFit : the record has neither.
    """
    u, v = samples(record, "u"), samples(record, "v")
    north, east = _current(record)
    if u is not None and np.isfinite(u).any():
        psi = samples(record, "psi") if np.any(north) or np.any(east) else None
        c, s = (np.cos(psi), np.sin(psi)) if psi is not None else (0.0, 0.0)
        ahead = u - north * c - east * s
        sway = None if v is None or not np.isfinite(v).any() else v + north * s - east * c
        return ahead if sway is None else _signed(np.hypot(ahead, sway), ahead)
    if samples(record, "x") is None or samples(record, "y") is None:
        raise CannotFit(f"record {record.name} has no column surge_m_s and no positions")
    x, y = (_slope(record.time_s, require(record, symbol)) for symbol in ("x", "y"))
    x, y = x - north, y - east
    psi = samples(record, "psi")
    if psi is None or not np.isfinite(psi).any():
        return np.hypot(x, y)
    psi = bridged(psi, record.time_s)
    return _signed(np.hypot(x, y), x * np.cos(psi) + y * np.sin(psi))


def _signed(size: np.ndarray, ahead: np.ndarray) -> np.ndarray:
    """The size (N,) of a velocity, negative where its part ahead (N,) is."""
    return np.where(ahead < 0.0, -size, size)


def _current(record: Record) -> tuple[np.ndarray | float, np.ndarray | float]:
    """Measured velocity of the water towards north and east (N,), m/s; zero where none was measured."""
    flow = flow_of(record, CURRENT)
    if flow is None:
        return 0.0, 0.0
    time, velocity = flow
    return np.interp(record.time_s, time, velocity[:, 0]), np.interp(record.time_s, time, velocity[:, 1])


def wind_of(record: Record) -> tuple[np.ndarray, np.ndarray]:
    """Velocity of the true wind towards north and towards east (N,), m/s.

    Raises
    ------
    CannotFit : the record has no wind.
    """
    if not (record.has("wind_speed_m_s") and record.has("wind_direction_rad")):
        raise CannotFit(f"record {record.name} has no columns wind_speed_m_s and wind_direction_rad")
    size, source = record.column("wind_speed_m_s"), record.column("wind_direction_rad")
    return -size * np.cos(source), -size * np.sin(source)


def _slope(time_s: np.ndarray, values: np.ndarray, reach: int = 5) -> np.ndarray:
    """Slope (N,) of a series by straight lines through up to 2 reach + 1 of its known samples."""
    known = np.flatnonzero(np.isfinite(values))
    if known.size < 2:
        return np.full(values.size, np.nan)
    t, y = time_s[known] - time_s[known[0]], values[known]
    low, high = (np.clip(np.arange(known.size) + side, 0, known.size) for side in (-reach, reach + 1))
    sums = [np.concatenate([[0.0], np.cumsum(s)]) for s in (np.ones_like(t), t, y, t * t, t * y)]
    n, st, sy, stt, sty = (s[high] - s[low] for s in sums)
    slope = (n * sty - st * sy) / (n * stt - st**2)
    return np.interp(time_s, time_s[known], slope)


def noise_floor(values: np.ndarray) -> float:
    """A standard deviation (> 0) at the rounding level of a series (N,), for channels without visible noise."""
    known = values[np.isfinite(values)]
    return float(max(np.abs(known).max(initial=0.0), 1e-6) * 1e-12)


def averaged(record: Record, samples: int = 200) -> Record:
    """Means of the record over equal stretches, about `samples` of them: their differences have less noise."""
    window = max(1, record.n // samples)
    if window == 1:
        return record
    n = record.n // window * window

    def mean(values: np.ndarray) -> np.ndarray:
        return values[:n].reshape(-1, window).mean(axis=1)

    channels = dict(record.channels)
    if record.has("heading_rad"):
        channels["heading_rad"] = record.heading_unwrapped()
    return replace(record, time_s=mean(record.time_s), channels={k: mean(v) for k, v in channels.items()})


def at_equal_steps(record: Record) -> Record:
    """The record at equal time steps: samples interpolated, gaps kept."""
    if record.uniform():
        return record
    time = record.time_s
    grid = np.arange(time[0], time[-1] + 1e-6 * record.dt, record.dt)
    channels = dict(record.channels)
    if record.has("heading_rad"):
        channels["heading_rad"] = record.heading_unwrapped()
    nearest = np.abs(grid[:, None] - time[np.clip(np.searchsorted(time, grid), 1, len(time) - 1)[:, None] + [-1, 0]])
    gap = nearest.min(axis=1) > 0.75 * record.dt
    found = {k: np.where(gap, np.nan, np.interp(grid, time, v)) for k, v in channels.items()}
    return type(record)(grid, found, record.name, record.meta)


@dataclass(frozen=True)
class Series:
    """One record on an equal time grid of M + 1 points, SI and radians.

    inputs (M + 1, nu) in the model's order.  outputs (N, c) are the measured states `columns` (c,) (indices into the
    model's states), nan = gap, taken at grid position index (N,) + part (N,) of a step (linear in between; part is 0
    throughout for an evenly sampled record).  start (n,) is the initial state as estimated from the record and
    start_sd (n,) its standard deviation (0: known); noise (c,) the standard deviations of the sensors, estimated too.
    """

    name: str
    dt: float
    inputs: np.ndarray
    outputs: np.ndarray
    columns: np.ndarray
    index: np.ndarray
    part: np.ndarray
    start: np.ndarray
    start_sd: np.ndarray
    noise: np.ndarray

    @cached_property
    def known(self) -> np.ndarray:
        """(N, c) which outputs are no gaps."""
        return np.isfinite(self.outputs)

    @cached_property
    def complete(self) -> bool:
        """Whether no output is a gap."""
        return bool(self.known.all())

    @cached_property
    def on_grid(self) -> bool:
        """Whether every sample is at a point of the grid."""
        return not self.part.any()

    @cached_property
    def is_grid(self) -> bool:
        """Whether the samples are the points of the grid, from the first one on without a gap."""
        return self.on_grid and np.array_equal(self.index, np.arange(self.index.size))

    @property
    def n_outputs(self) -> int:
        """Measured values that are not gaps."""
        return int(self.known.sum())

    def without(self, column: int) -> Series:
        """The series without one of its outputs."""
        kept = self.columns != column
        return replace(self, outputs=self.outputs[:, kept], columns=self.columns[kept], noise=self.noise[kept])

    def stretch(self, first: int, last: int, samples: slice | np.ndarray, start: np.ndarray) -> Series:
        """The points first .. last of the grid with some of the samples, from an initial state (n,)."""
        return replace(
            self,
            inputs=np.ascontiguousarray(self.inputs[first : last + 1]),
            outputs=self.outputs[samples],
            index=self.index[samples] - first,
            part=self.part[samples],
            start=start,
        )

    def observe(self, grid: np.ndarray) -> np.ndarray:
        """Values (N, ...) at the measured times of something given on the grid (M + 1, ...)."""
        if self.is_grid:
            return grid[: self.index.size]
        if self.on_grid:
            return grid[self.index]
        part = self.part.reshape(-1, *([1] * (grid.ndim - 1)))
        after = np.minimum(self.index + 1, grid.shape[0] - 1)
        return (1.0 - part) * grid[self.index] + part * grid[after]


def series_of(record: Record, model: Model, symbols: Sequence[str] = MEASURED) -> Series:
    """A record as a `Series`, with those of the states `symbols` as outputs that it measures.

    Raises
    ------
    CannotFit : the record measures none of them, or lacks an input.
    """
    measured = {s: values for s in symbols if s in model.states and (values := samples(record, s)) is not None}
    measured = {s: values for s, values in measured.items() if np.isfinite(values).any()}
    if not measured:
        raise CannotFit(f"record {record.name} has none of the columns that method and model need")
    dt, grid, index, part = _grid(record)
    given = inputs_of(record, model)
    inputs = np.column_stack([np.interp(grid, record.time_s, bridged(given[s], record.time_s)) for s in model.inputs])
    start, start_sd = initial_state_of(record, model)
    return Series(
        name=record.name,
        dt=dt,
        inputs=np.ascontiguousarray(inputs),
        outputs=np.column_stack(list(measured.values())),
        columns=np.array([model.states.index(s) for s in measured]),
        index=index,
        part=part,
        start=start,
        start_sd=start_sd,
        noise=np.array([sensor_sd(values) for values in measured.values()]),
    )


def with_weather(series: Series, record: Record, model: Model) -> Series:
    """The series with the inputs of the model's environment variant behind its own, where wind or current counts.

    record : the record that the series was made of, or one of more samples that it was thinned from.
    """
    grid = record.time_s[0] + series.dt * np.arange(len(series.inputs))
    weather = measured_weather(record, model, grid)
    return series if weather is None else replace(series, inputs=np.hstack([series.inputs, weather]))


def _grid(record: Record) -> tuple[float, np.ndarray, np.ndarray, np.ndarray]:
    """Step, times, and the place of every sample on the grid.

    Half the median step for uneven records; a record with missing rows keeps its step.
    """
    time = record.time_s
    if record.uniform():
        dt = (time[-1] - time[0]) / (time.size - 1)
        return dt, time, np.arange(time.size), np.zeros(time.size)
    dt = record.dt
    place = (time - time[0]) / dt
    if np.abs(place - np.round(place)).max() > 1e-3:
        dt, place = dt / 2.0, place * 2.0
    else:
        place = np.round(place)
    index = np.floor(place).astype(np.int64)
    grid = time[0] + dt * np.arange(int(np.ceil(place[-1])) + 1)
    return dt, grid, index, place - index


def initial_state_of(record: Record, model: Model) -> tuple[np.ndarray, np.ndarray]:
    """Initial state (n,) estimated from a record, and its standard deviation (n,), SI.

    Measured states: the first sample, with the noise of the sensor.  A yaw rate that is not measured: the first slope
    of the heading.  The yaw acceleration q = r_dot, which takes the place of the hidden state w of a second-order
    response model (w = q - c rudder): zero, with a typical slope of the yaw rate as standard deviation.  All others: as
    on a steady straight course, surge and sway with a tenth of the speed, positions exactly zero.
    """
    from ...models.simulate import initial_state

    steady = initial_state(model)
    start = np.where(np.isfinite(steady), steady, 0.0)
    spread = np.zeros(start.size)
    for i, symbol in enumerate(model.states):
        values = samples(record, symbol) if symbol in MEASURED else None
        if symbol == "w":
            spread[i] = _typical_slope(record.time_s, yaw_rate_of(record))
        elif values is not None and np.isfinite(values).any():
            start[i], spread[i] = values[np.isfinite(values)][0], sensor_sd(values)
        elif symbol == "r":
            slope = yaw_rate_of(record)
            start[i], spread[i] = slope[np.isfinite(slope)][0], sensor_sd(slope)
        elif symbol in ("u", "v"):
            spread[i] = 0.1 * model.speed_m_s if np.isfinite(model.speed_m_s) else 1.0
    return start, spread


def yaw_rate_of(record: Record) -> np.ndarray:
    """Yaw rate (N,), rad/s: measured, else the heading differenced over its gaps.

    Raises
    ------
    CannotFit : the record has neither.
    """
    rate = samples(record, "r")
    if rate is not None and np.isfinite(rate).any():
        return rate
    heading = require(record, "psi")
    known = np.isfinite(heading)
    if known.sum() < 2:
        raise CannotFit(f"record {record.name} has no usable yaw rate or heading")
    rate = np.full(record.n, np.nan)
    rate[known] = np.gradient(heading[known], record.time_s[known])
    return rate


def _typical_slope(time_s: np.ndarray, values: np.ndarray) -> float:
    """Root mean square slope of values (N,) over windows of a hundredth of the record (at least 5 samples)."""
    known = np.isfinite(values)
    window = max(5, known.sum() // 100)
    rise = values[known][window:] - values[known][:-window]
    run = time_s[known][window:] - time_s[known][:-window]
    return float(np.sqrt(np.mean((rise / run) ** 2))) if rise.size else 0.0
