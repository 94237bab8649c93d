"""Free runs and predictions some time ahead of one model along one stretch of a record.

The stretch is what the hull did: behind the model's instruments, in its rudder sign.  Runs start from states that are
smoothed from the record alone (`smoothed_states`); a state that it does not measure starts as on a straight course,
and at later origins as the model has it when it is run up to there.  Measured wind acts where the vessel has windage;
no random forces do.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from ...models.errors import CannotFit
from ...models.model import CHANNELS
from ..observers.smoothed_states import smoothed_states
from ..records.series import samples, series_of, with_weather, yaw_rate_of
from ..results.prediction import BOUND, SYMBOLS, Squares, divergence, squares
from ..results.predictor import ModelPredictor

if TYPE_CHECKING:
    from ...datasets.record import Record
    from ...models.model import Model
    from ..records.series import Series
    from ..results.predictor import Predictor

ORIGINS = 200
"""Predictions start at so many samples of a stretch at most, evenly spread."""
ANY_RATE = 1e6
"""Limit of velocities, m/s, and of the yaw rate, rad/s, where the record shows no motion."""
NEXT = 1.5
"""A sample follows another directly where it comes within so many median steps."""


class FreeRun(NamedTuple):
    """States (M + 1, n) on the grid of the stretch, held from where the run diverged, and when that was, s."""

    states: np.ndarray
    diverged_s: float | None


@dataclass(frozen=True)
class Stretch:
    """A model and a stretch of a record without long gaps: what the hull did, and its series.

    predictor : a black box that predicts in the model's place; None: the model itself.
    """

    model: Model
    record: Record
    series: Series
    predictor: Predictor | None = None

    @classmethod
    def of(cls, model: Model, record: Record, predictor: Predictor | None = None) -> Stretch:
        """Raises CannotFit where the record lacks an input or measures no state of the model."""
        series = series_of(record, model, SYMBOLS)  # a black box knows the model's inputs alone
        return cls(model, record, series if predictor else with_weather(series, record, model), predictor)

    @property
    def grid_s(self) -> np.ndarray:
        """Times (M + 1,) of the grid, s."""
        return self.record.time_s[0] + self.series.dt * np.arange(len(self.series.inputs))

    @cached_property
    def known(self) -> dict[int, np.ndarray]:
        """Number of a state -> its smoothed values (M + 1,), of the states that the record determines."""
        names = {"w": "q"}
        found = smoothed_states(self.record, self.grid_s)
        return {i: found[s] for i, name in enumerate(self.model.states) if (s := names.get(name, name)) in found}

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
        """State (n,) at a grid point: smoothed, and as on a straight course where the record does not tell it."""
        state = self.series.start.copy()
        for number, values in self.known.items():
            state[number] = values[point]
        return state

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
        chosen = range(0, n - 1, max(1, -(-n // ORIGINS)))
        state, before = self.series.start.copy(), 0
        for sample in chosen:
            first = int(self.series.index[sample])
            if len(self.known) < state.size and first > before:
                state = self.run(state, self.series.inputs[before : first + 1]).states[-1].copy()
                state = self._with_rate(state, first)
            for number, values in self.known.items():
                state[number] = values[first]
            before = first
            yield sample, first, state.copy()

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


def _between(states: np.ndarray, place: float) -> np.ndarray:
    """The state (n,) at a place between the rows of states (K, n)."""
    row = min(int(place), len(states) - 2) if len(states) > 1 else 0
    part = place - row
    return states[row] if part == 0.0 else (1.0 - part) * states[row] + part * states[row + 1]
