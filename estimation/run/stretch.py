"""One model along one stretch of a record: its start state, inputs, free run, and predictions some time ahead.

The stretch is what the hull did: behind the model's instruments, in its rudder sign.  Runs start from states that are
smoothed from the record alone (`smoothed_states`), so that all models start alike and the noise of a single sample does
not count; a velocity that it does not measure starts as the model has it then (`start_state`), and at later origins as
when it is run up to there.  Measured current acts, and measured wind where the vessel has windage; no random forces do.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from functools import cached_property
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from ...datasets.instruments import hull_record
from ...models.errors import CannotFit
from ...models.model import CHANNELS
from ...models.regimes import CLOCK
from ...models.simulate import stable_step_s
from ...models.time_scale import time_scale_s
from ..observers.smoothing import smoothed_states
from ..records.gaps import SHORTEST, clock_of, stretches
from ..records.series import samples, series_of, with_weather, yaw_rate_of
from ..results.predictor import ModelPredictor
from .squares import Squares, squares
from .start import start_state

if TYPE_CHECKING:
    from ...datasets.record import Record
    from ...models.model import Model
    from ..records.series import Series
    from ..results.predictor import Predictor

SYMBOLS = ("u", "v", "r", "psi", "x", "y")
"""States whose channels are predicted."""
BOUND = 10.0
"""A run has diverged where a velocity or the yaw rate exceeds this multiple of the largest in the record."""
ORIGINS = 200
"""Predictions start at so many samples of a stretch at most, evenly spread."""
ANY_RATE = 1e6
"""Limit of velocities, m/s, and of the yaw rate, rad/s, where the record shows no motion."""
FOLLOW = 0.25
"""Ship lengths sailed after which a run that follows the record takes up the measured states anew."""
FINEST = 1e-3
"""Share of a model's own step that the step of its runs is at least."""
NEXT = 1.5
"""A sample follows another directly where it comes within so many median steps."""


class FreeRun(NamedTuple):
    """States (M + 1, n) on the grid of the stretch, held from where the run diverged, and when that was, s."""

    states: np.ndarray
    diverged_s: float | None


@dataclass(frozen=True)
class Stretch:
    """A model and a stretch of a record without long gaps: what the hull did, and its series.

    place : the samples of the record that it is;  predictor : a black box that predicts in the model's place; None:
    the model itself.  begin_s : time of its first sample from the start of the record.
    """

    model: Model
    record: Record
    series: Series
    place: slice
    predictor: Predictor | None = None
    begin_s: float = 0.0

    @classmethod
    def of(
        cls,
        model: Model,
        record: Record,
        place: slice = slice(None),
        predictor: Predictor | None = None,
        start_s: float | None = None,
    ) -> Stretch:
        """The samples `place` of what the hull did; raises CannotFit as `stretches_of`.

        start_s : time at which the whole record starts; None: that of `record`.
        """
        own = record.slice(place.start, place.stop)
        begin_s = float(own.time_s[0] - (record.time_s[0] if start_s is None else start_s))
        series = series_of(own, model, SYMBOLS)  # a black box knows the model's inputs alone
        series = series if predictor else with_weather(series, own, model)
        model = model if predictor or model.is_3dof else _finely_integrated(model, own, series)
        return cls(model, own, series, place, predictor, begin_s)

    @property
    def grid_s(self) -> np.ndarray:
        """Times (M + 1,) of the grid, s."""
        return self.record.time_s[0] + self.series.dt * np.arange(len(self.series.inputs))

    @cached_property
    def known(self) -> dict[int, np.ndarray]:
        """Number of a state -> its smoothed values (M + 1,), of the states that the record determines."""
        return known_states(self.model, self.record, self.grid_s)

    @cached_property
    def limits(self) -> np.ndarray:
        """Absolute values (n,) above which a run has diverged: ten times the largest recorded."""
        speeds = [v for s in ("u", "v") if (v := samples(self.record, s)) is not None]
        speed = float(np.nanmax(np.abs(speeds))) if speeds and np.isfinite(speeds).any() else self.model.speed_m_s
        rate = float(np.nanmax(np.abs(self._yaw_rate())))
        largest = {"u": speed, "v": speed, "r": rate}
        bounds = {name: BOUND * value if 0.0 < value < np.inf else ANY_RATE for name, value in largest.items()}
        return np.array([bounds.get(name, np.inf) for name in self.model.states])

    def free_run(self) -> FreeRun:
        """The run over the whole stretch."""
        return self.run(self.state_at(0), self.series.inputs)

    def state_at(self, point: int) -> np.ndarray:
        """State (n,) at a grid point: smoothed, and as `start_state` says where the record does not tell it."""
        known = {number: values[point:] for number, values in self.known.items()}
        approach = self.series.start.copy()
        if CLOCK in self.model.states:
            approach[self.model.states.index(CLOCK)] = self.begin_s + point * self.series.dt
        return start_state(self.model, approach, known, self.series.inputs[point:], self.series.dt)

    def channels(self, states: np.ndarray) -> dict[str, np.ndarray]:
        """States (K, n) as channels of a record: column name -> (K,)."""
        return {CHANNELS[s]: states[:, i] for i, s in enumerate(self.model.states) if s in SYMBOLS}

    def run(self, start: np.ndarray, inputs: np.ndarray) -> FreeRun:
        """The run from a state (n,) with inputs (K, nu) on the grid's step."""
        with np.errstate(all="ignore"):
            predictor = self.predictor or ModelPredictor(self.model)
            states = predictor.simulate(np.ascontiguousarray(inputs), self.series.dt, start)
        lost = divergence(states, self.limits)
        if lost is None:
            return FreeRun(states, None)
        states[lost:] = states[max(lost - 1, 0)] if lost else np.where(np.isfinite(start), start, 0.0)
        return FreeRun(states, lost * self.series.dt)

    def ahead(self, horizons_s: Sequence[float]) -> list[dict[int, Squares]]:
        """Sums of squared errors one sample ahead and at each horizon: state -> sums over the origins that have it."""
        columns = self.series.columns.tolist()
        longest = int(np.ceil((max(horizons_s, default=0.0) + 2.0 * self.record.dt) / self.series.dt)) + 1
        place = self.series.index + self.series.part
        pairs: list[tuple[list[np.ndarray], list[np.ndarray]]] = [([], []) for _ in range(1 + len(horizons_s))]
        for origin, first, state in self._origins():
            states = self.run(state, self.series.inputs[first : first + longest]).states
            for (observed, predicted), target in zip(pairs, self._targets(origin, horizons_s), strict=True):
                if target is not None:
                    observed.append(self.series.outputs[target])
                    predicted.append(_between(states, place[target] - first)[columns])
        tables = [tuple(np.reshape(rows, (-1, len(columns))) for rows in pair) for pair in pairs]
        return [{n: squares(y[:, c], p[:, c]) for c, n in enumerate(columns)} for y, p in tables]

    def _origins(self) -> Iterator[tuple[int, int, np.ndarray]]:
        """Samples at which predictions start, with their grid points and states (n,)."""
        n = len(self.series.index)
        for sample in range(0, n - 1, max(1, -(-n // ORIGINS))):
            first = int(self.series.index[sample])
            yield sample, first, self.states_along[first].copy()

    @cached_property
    def states_along(self) -> np.ndarray:
        """States (M + 1, n): smoothed, and those that the record does not tell as the model has them when it is run
        along with the smoothed ones."""
        states = np.tile(self.state_at(0), (len(self.series.inputs), 1))
        for number, values in self.known.items():
            states[:, number] = values
        if len(self.known) == states.shape[1]:
            return states
        hidden = [i for i in range(states.shape[1]) if i not in self.known]
        for first in range(0, len(states) - 1, self._follow_steps):
            last = min(first + self._follow_steps, len(states) - 1)
            run = self.run(states[first], self.series.inputs[first : last + 1]).states
            run[-1] = self._with_rate(run[-1], last)
            states[first + 1 : last + 1, hidden] = run[1:, hidden]
        return states

    @cached_property
    def _follow_steps(self) -> int:
        """Grid steps over which a run goes on by itself where it is to follow the record."""
        try:
            return max(1, round(FOLLOW * time_scale_s(self.model) / self.series.dt))
        except CannotFit:
            return 1

    def _targets(self, origin: int, horizons_s: Sequence[float]) -> list[int | None]:
        """The next sample, and the one nearest to each time ahead; None where the record has none there."""
        time, step = self.record.time_s, self.record.dt
        following = origin + 1 if time[origin + 1] - time[origin] <= NEXT * step else None
        found: list[int | None] = [following]
        for horizon in horizons_s:
            wanted = time[origin] + horizon
            right = min(int(np.searchsorted(time, wanted)), time.size - 1)
            near = min(max(right - 1, 0), right, key=lambda i: abs(time[i] - wanted))
            found.append(near if abs(time[near] - wanted) <= 0.51 * step else None)
        return found

    def _with_rate(self, state: np.ndarray, at: int) -> np.ndarray:
        """A simulated state with q = r_dot in the place of the hidden w, as runs are started."""
        gain = self.model.kernels.RATE_GAIN
        if gain is not None and self.predictor is None:
            state[0] += self.model.coefficients[gain] * self.series.inputs[at, 0]
        return state

    def _yaw_rate(self) -> np.ndarray:
        """Measured or differenced yaw rate (N,); infinite where there is neither."""
        try:
            return yaw_rate_of(self.record)
        except CannotFit:
            return np.array([np.inf])


def _finely_integrated(model: Model, record: Record, series: Series) -> Model:
    """The response model with steps in which its runs are stable at the largest yaw rate of a record: those of a small
    craft that spins are far shorter than a ship's.  One that would need far shorter ones runs away."""
    with suppress(CannotFit):
        state = np.zeros(len(model.states))
        state[model.states.index("r")] = np.nanmax(np.abs(yaw_rate_of(record)))
        step_s = stable_step_s(model, state, series.inputs[0])
        return replace(model, max_step_s=step_s) if FINEST < step_s / model.max_step_s < 1.0 else model
    return model


def stretches_of(model: Model, record: Record, predictor: Predictor | None = None) -> list[Stretch]:
    """The stretches between long gaps of a record in the model's rudder sign, as runs of the hull.

    Raises
    ------
    CannotFit : the record lacks an input, measures no state of the model, or has no stretch without long gaps.
    """
    hull = hull_record(record, model)
    places = [slice(a, b) for a, b in stretches(hull, clock_of(model, [record])) if b - a > 1]
    if not places:
        raise CannotFit(f"no {SHORTEST} samples in turn with a rudder angle")
    return [Stretch.of(model, hull, place, predictor) for place in places]


def known_states(model: Model, record: Record, times_s: np.ndarray) -> dict[int, np.ndarray]:
    """Number of a state -> its values (T,) at some times, smoothed from the record alone, of those that it determines.

    The yaw acceleration q = r_dot takes the place of the hidden state w = q - c rudder.
    """
    found = smoothed_states(record, times_s)
    names = {name: "q" if name == "w" else name for name in model.states}
    return {i: found[names[name]] for i, name in enumerate(model.states) if names[name] in found}


def divergence(states: np.ndarray, limits: np.ndarray) -> int | None:
    """The first row of a run (N, n) that is not finite or has an absolute value above the limits (n,); None: none."""
    with np.errstate(invalid="ignore"):
        lost = ~(np.isfinite(states) & (np.abs(states) <= limits)).all(axis=1)
    return int(np.argmax(lost)) if lost.any() else None


def _between(states: np.ndarray, place: float) -> np.ndarray:
    """The state (n,) at a place between the rows of states (K, n)."""
    row = min(int(place), len(states) - 2) if len(states) > 1 else 0
    part = place - row
    return states[row] if part == 0.0 else (1.0 - part) * states[row] + part * states[row + 1]
