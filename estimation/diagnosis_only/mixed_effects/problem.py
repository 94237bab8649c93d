"""A model and the records that it is run freely on, prepared for fits; errors of its runs."""

from __future__ import annotations

from collections.abc import Callable, Collection, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np

from ....models.errors import CannotFit
from ....models.regimes import Regime
from ....models.time_scale import time_scale_s
from ...records.series import MEASURED, Series, samples, series_of, with_weather
from ...run.start import start_state
from ...run.stretch import known_states

if TYPE_CHECKING:
    from ....datasets.record import Record
    from ....models.model import Model

THRUST = "propeller_thrust_N"
CORRELATION = 1.7
"""Correlation time of the residuals of free runs, in ship lengths sailed (10 s for a 7 m model at 1.18 m/s)."""
STEP, INTEGRATION_STEP = 0.035, 0.05
"""Time step, in ship lengths sailed, that records are thinned to, and the largest of the integration: RK4 with it errs
by under 1e-5 of the yaw rate and the speeds of every vessel here."""
NEUTRAL_ANGLE_SD = np.deg2rad(0.3)
"""Standard deviation of a record's neutral rudder angle about the common one, rad."""
START_SD = {"u": 2.5e-3, "v": 2.5e-3, "r": 3e-3, "psi": 2e-3}
"""Standard deviation of a record's initial state about the estimated one: shares of speed, of speed / length, rad."""
UNMEASURED_SD = 0.03
"""That of velocities that no record measures, and whose start is the model's: share of speed."""
FLOOR = {"u": 2.5e-3, "v": 2.5e-3, "r": 5e-3, "psi": np.deg2rad(0.5), THRUST: 0.05}
"""Error below which a channel counts as perfect: shares of speed, of speed / length, rad, share of the mean thrust."""
LARGEST = 20.0
"""Largest residual, in the channel's own size, that a run which leaves the record counts with."""


@dataclass(frozen=True)
class Run:
    """One record prepared for free runs: its series, thinned, and the thrust (N,) where it was measured.

    The inputs of the series hold the measured wind where it counts, see `series.with_weather`.

    measured : (N, C) the channels that count, nan where the record lacks one.
    """

    series: Series
    thrust: np.ndarray | None
    measured: np.ndarray
    duration_s: float

    @property
    def name(self) -> str:
        """Name of the record."""
        return self.series.name


@dataclass(frozen=True)
class LocalChange:
    """Numbers that differ in a regime: place in `Model.theta` and change in a regime of size one, of each.

    size : what is expected.
    """

    name: str
    regime: Regime
    changes: tuple[tuple[int, float], ...]
    size: float

    def inside(self, theta: np.ndarray, size: float) -> np.ndarray:
        """Theta (m,) inside the regime."""
        out = theta.copy()
        for place, change in self.changes:
            out[place] += size * change
        return out


@dataclass(frozen=True, eq=False)
class Problem:
    """A model and the records that it is fitted to.

    channels : symbols of the states that count, and THRUST where a record measures it.
    thrust : thrust [N] from states (N, n), inputs (N, nu) and theta; None where the family has none.
    threads : threads that records, and choices between several fits, may take.
    local : what differs in a regime; its size is then the last element of theta, after the model's own.
    """

    model: Model
    runs: tuple[Run, ...]
    channels: tuple[str, ...]
    length_s: float
    thrust: Callable[[np.ndarray, np.ndarray, np.ndarray], np.ndarray] | None
    threads: int = 1
    local: LocalChange | None = None

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the elements of theta."""
        own = (*self.model.coordinates, *self.model.constant_names)
        return own if self.local is None else (*own, self.local.name)

    @property
    def theta(self) -> np.ndarray:
        """The model's own numbers, and the expected size of what differs in a regime."""
        return self.model.theta if self.local is None else np.append(self.model.theta, self.local.size)

    @cached_property
    def unit(self) -> np.ndarray:
        """(C,) size of each channel in which FLOOR and START_SD are shares."""
        sizes = units(self.model, self.length_s) | {THRUST: self._mean_thrust}
        return np.array([sizes[c] for c in self.channels])

    @property
    def _mean_thrust(self) -> float:
        known = [np.nanmean(np.abs(run.thrust)) for run in self.runs if run.thrust is not None]
        return float(np.mean(known)) if known else 1.0

    @cached_property
    def floor(self) -> np.ndarray:
        """(C,) error below which a channel counts as perfect, SI."""
        return self.unit * np.array([FLOOR[c] for c in self.channels])

    @cached_property
    def known(self) -> np.ndarray:
        """(C,) channels whose error size is the floor: a fit must not give up measured thrust for other channels."""
        return np.array([c == THRUST for c in self.channels])

    @property
    def state_places(self) -> list[int]:
        """Places of the states (S,) among the channels."""
        return [c for c, name in enumerate(self.channels) if name != THRUST]

    @cached_property
    def motion(self) -> np.ndarray:
        """(S,) standard deviation of each state over all records, SI."""
        return np.nanstd(np.concatenate([run.series.outputs for run in self.runs]), axis=0)

    @cached_property
    def noise_variance(self) -> np.ndarray:
        """(C,) mean variance of the sensors' noise, SI; none is known of thrust."""
        known = np.mean([run.series.noise**2 for run in self.runs], axis=0)
        return np.pad(known, (0, len(self.channels) - len(known)))

    @property
    def states(self) -> tuple[str, ...]:
        """States whose initial value belongs to a record."""
        return started_states(self.model)

    @cached_property
    def own_sd(self) -> np.ndarray:
        """(k,) prior standard deviations of a record's own effects: neutral rudder angle, initial states."""
        return own_sd(self.model, self.length_s, self.channels)

    @cached_property
    def weight(self) -> np.ndarray:
        """(R,) independent values that a record's duration amounts to."""
        return np.array([run.duration_s for run in self.runs]) / (CORRELATION * self.length_s)

    def residuals(self, theta: np.ndarray, run: Run, own: np.ndarray) -> np.ndarray:
        """Measured minus simulated channels (N, C), SI; nan at gaps, LARGEST units where the run is lost.

        Eq. 1 of docs/mathematics/calibration.md.

        theta : the model's, or that of its environment variant, whose wind coefficients then take part.
        """
        from ....models.simulate import simulate_in_regime, substeps, variant

        series, model = run.series, self.model
        inputs = series.inputs.copy()
        inputs[:, 0] += own[0]
        start = series.start.copy()
        for value, symbol in zip(own[1:], self.states, strict=True):
            start[model.states.index(symbol)] += value
        if model.kernels.RATE_GAIN is not None:  # the simulated state is w = q - c rudder
            start[0] -= theta[model.kernels.RATE_GAIN] * inputs[0, 0]
        states, count = np.empty((len(inputs), start.size)), substeps(model, series.dt)
        everywhere, size = (theta, 0.0) if self.local is None else (theta[:-1], float(theta[-1]))
        kernels, numbers = variant(model, inputs.shape[1], everywhere)
        if self.local is None or size == 0.0:
            kernels.simulate(start, inputs, numbers, series.dt / count, count, False, states)
        else:
            both = numbers, self.local.inside(numbers, size)
            simulate_in_regime(kernels, self.local.regime, start, inputs, both, (series.dt / count, count), states)
        found = [series.observe(states[:, series.columns])]
        if THRUST in self.channels:
            found.append(self._thrust_of(run, states, inputs, theta))
        error = run.measured - np.column_stack(found)
        lost = ~np.isfinite(error) & np.isfinite(run.measured)
        with np.errstate(invalid="ignore"):
            error = np.clip(error / self.unit, -LARGEST, LARGEST)
        return np.where(lost, LARGEST, error) * self.unit

    def _thrust_of(self, run: Run, states: np.ndarray, inputs: np.ndarray, theta: np.ndarray) -> np.ndarray:
        if run.thrust is None or self.thrust is None:
            return np.full(len(run.series.index), np.nan)
        with np.errstate(all="ignore"):
            own = self.model.theta.size
            return run.series.observe(self.thrust(states, inputs[:, : len(self.model.inputs)], theta[:own]))


@dataclass(frozen=True)
class Squares:
    """Sums of squared errors (C,) and counts (C,) of one record."""

    total: np.ndarray
    count: np.ndarray


def units(model: Model, length_s: float) -> dict[str, float]:
    """State -> the unit of START_SD and FLOOR, SI; length_s : time of one ship length, s."""
    speed = model.speed_m_s if np.isfinite(model.speed_m_s) else 1.0
    return {"u": speed, "v": speed, "r": 1.0 / length_s, "psi": 1.0}


def started_states(model: Model) -> tuple[str, ...]:
    """States whose initial value belongs to a record."""
    return tuple(s for s in START_SD if s in model.states)


def own_sd(model: Model, length_s: float, measured: Collection[str]) -> np.ndarray:
    """(k,) prior standard deviations of a record's own effects, SI: neutral rudder angle, then `started_states`."""
    return np.array([NEUTRAL_ANGLE_SD, *start_sd(model, length_s, measured)])


def start_sd(model: Model, length_s: float, measured: Collection[str]) -> np.ndarray:
    """(S,) prior standard deviations of the initial values of `started_states`, SI; measured : states that are."""
    unit = units(model, length_s)
    sd = {s: UNMEASURED_SD if s in ("u", "v") and s not in measured else share for s, share in START_SD.items()}
    return np.array([sd[s] * unit[s] for s in started_states(model)])


def coarse(record: Record, length_s: float) -> Record:
    """The record thinned to STEP."""
    return record.thinned(max(1, int(STEP * length_s / record.dt + 1e-9)))


def coarsely_integrated(model: Model, length_s: float) -> Model:
    """The model with integration steps of INTEGRATION_STEP where its own are shorter."""
    return replace(model, max_step_s=max(model.max_step_s, INTEGRATION_STEP * length_s))


def problem(model: Model, records: Sequence[Record], threads: int = 1) -> Problem:
    """The model and records as a problem; records are thinned to STEP.

    Raises
    ------
    CannotFit : no record, the model has no speed and length to scale by, or a record lacks a channel.
    """
    length_s = time_scale_s(model)
    symbols = [s for s in MEASURED if s in model.states and all(_measures(r, s) for r in records)]
    if not records or not symbols:
        raise CannotFit("no record, or no state that all records measure")
    from ....models.outputs import thrust_of

    thrust = thrust_of(model.family)
    held = thrust is not None and any(record.has(THRUST) for record in records)
    channels = (*symbols, *((THRUST,) if held else ()))
    runs = tuple(_run(record, model, channels, length_s) for record in records)
    return Problem(coarsely_integrated(model, length_s), runs, channels, length_s, thrust, threads)


def _measures(record: Record, symbol: str) -> bool:
    values = samples(record, symbol)
    return values is not None and bool(np.isfinite(values).any())


def _run(record: Record, model: Model, channels: Sequence[str], length_s: float) -> Run:
    thinned = coarse(record, length_s)
    series = with_weather(series_of(thinned, model, [c for c in channels if c != THRUST]), record, model)
    known = known_states(model, record, record.time_s[0] + series.dt * np.arange(len(series.inputs)))
    series = replace(series, start=start_state(model, series.start, known, series.inputs, series.dt))
    thrust, measured = _smoothed(record, thinned) if record.has(THRUST) else None, series.outputs
    if THRUST in channels:
        missing = np.full(len(series.index), np.nan)
        measured = np.column_stack([measured, missing if thrust is None else thrust])
    return Run(series, thrust, measured, float(record.time_s[-1] - record.time_s[0]))


def _smoothed(record: Record, thinned: Record) -> np.ndarray:
    """Thrust at the thinned samples, as the mean over twelve of them."""
    values, n = record.column(THRUST), max(1, round(12.0 * thinned.dt / record.dt))
    known = np.isfinite(values)
    kernel = np.ones(n)
    total = np.convolve(np.where(known, values, 0.0), kernel, "same")
    count = np.convolve(known.astype(float), kernel, "same")
    mean = np.where(count > 0.0, total / np.maximum(count, 1.0), np.nan)
    return np.interp(thinned.time_s, record.time_s, mean)


def squares(p: Problem, theta: np.ndarray, run: Run, own: np.ndarray | None = None) -> Squares:
    """Squared errors of one free run; own: the record's own effects, none unless given."""
    return squares_of(p.residuals(theta, run, np.zeros(p.own_sd.size) if own is None else own))


def squares_of(error: np.ndarray) -> Squares:
    """Squares of errors (N, C)."""
    return Squares(np.nansum(error**2, axis=0), np.isfinite(error).sum(axis=0))


def pooled(parts: Sequence[Squares]) -> np.ndarray:
    """Root mean squared error (C,) over records; nan where nothing was measured."""
    count = sum(part.count for part in parts)
    with np.errstate(invalid="ignore", divide="ignore"):
        return np.sqrt(sum(part.total for part in parts) / count)
