"""The linearisation of free runs about a point: how errors change with numbers and with own effects of units.

A column is the difference of two runs over the step of its number; all perturbed runs are lanes of one simulation
(`models.lanes`).  Forces along the motion, and numbers of the model that change in regimes, are many times a few
influences, each with a share along the run: their columns follow from how the state a sample ahead answers the state
and these influences.  Columns of the model's own numbers, which many fits about one point share, are kept.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from functools import cached_property
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from ...estimation.selection.quadratic import Quadratic
from ...models.drivers import responses
from ...models.simulate import changes_along, slopes_along
from .units import Lane

if TYPE_CHECKING:
    from ...estimation.selection.number import Number
    from ...models.model import Model
    from .bank import Place
    from .problem import Driven, FreeRuns

STEP, OWN_STEP = 0.05, 0.3
"""Steps of the differences, in prior standard deviations of numbers and of own effects."""
LANES = 1024
"""Runs that are simulated at once, about: more only need memory."""
SHARED = ("term", "window", "regime")
"""Kinds of numbers that share few influences: forces along the motion, numbers of the model in regimes."""
FEW = 12
"""Such numbers up to which differences of runs are less work than the slopes along the runs."""
BENDING = ("sensor", "drift", "regime")
"""Kinds of numbers beside which all columns are differences of runs."""
Influence = int | tuple[tuple[int, float], ...]
"""A force on an axis (column of the environment's inputs), or changes of numbers of the model (place, size)."""


class _Slopes(NamedTuple):
    """How a unit's run answers small changes: the state a sample ahead by the state (M, n, n), and by each influence
    (M, n);  the thrust by the states (M + 1, n), zero where it is no channel."""

    run: Driven
    by_state: np.ndarray
    by_influence: dict[Influence, np.ndarray]
    thrust: np.ndarray


class Linearisation:
    """Free runs about a point, as sums of products of the columns of any numbers.

    values : of the numbers by name.  own : effects (K, m) of the units.
    """

    def __init__(self, runs: FreeRuns, values: Mapping[str, float], own: np.ndarray) -> None:
        self.runs, self.values, self.own = runs, dict(values), own
        self._kept: dict[tuple[str, float], list[np.ndarray]] = {}
        self._slopes: dict[int, _Slopes] = {}
        self._is_bent = bool({*BENDING} & {runs.places[name].kind for name, x in values.items() if x})

    def is_at(self, values: Mapping[str, float], own: np.ndarray) -> bool:
        """Whether this is the point."""
        here, there = ({n: x for n, x in point.items() if x} for point in (self.values, values))
        return here == there and np.array_equal(self.own, own)

    def quadratic(self, runs: FreeRuns, numbers: Sequence[Number]) -> Quadratic:
        """Sums of products of the columns of some numbers, eq. 2 of docs/mathematics/pieces.md.

        runs : these ones, with places of the numbers.
        """
        self.runs = runs
        keys = [self._key(n) for n in numbers]
        sharing = [n for n in numbers if self._shares(n)]
        sharing = sharing if len(sharing) > FEW else []
        ready = {*self._kept, *map(self._key, sharing)}
        others = [n for n, key in zip(numbers, keys, strict=True) if key not in ready]
        to_keep = {self._key(n): list[np.ndarray]() for n in others if runs.places[n.name].kind == "model"}
        grams, count = list[np.ndarray](), max(1, LANES // (len(others) + 1))
        for part in (range(len(self.own))[i : i + count] for i in range(0, len(self.own), count)):
            for k, columns in zip(part, self._simulated(part, others), strict=True):
                columns |= {key: self._kept[key][k] for key in keys if key in self._kept} | self._of_shares(k, sharing)
                block = np.stack([*(columns[key] for key in keys), *self._base[k]])
                block = np.ascontiguousarray(block.transpose(1, 0, 2))
                grams.append(block @ block.transpose(0, 2, 1))
                for key, kept in to_keep.items():
                    kept.append(columns[key].copy())
        self._kept |= to_keep
        return Quadratic(np.array(grams), runs.weight, self.own, runs.own_sd)

    def _key(self, number: Number) -> tuple[str, float]:
        return number.name, self._step(number)

    def _step(self, number: Number) -> float:
        return number.step(self.values.get(number.name, 0.0), STEP)

    # ---- columns (C, N) as differences of runs
    @cached_property
    def _base(self) -> list[np.ndarray]:
        """Columns (m + 1, C, N) of each unit: of its own effects, and the errors."""
        steps = OWN_STEP * self.runs.own_sd
        moves = [*np.diag(steps), np.zeros(steps.size)]
        blocks = self.runs.errors(
            [Lane(k, self.values, own + move) for k, own in enumerate(self.own) for move in moves]
        )
        for block in blocks:
            block[:, :-1] = (block[:, :-1] - block[:, -1:]) / steps[:, None]
        return [np.ascontiguousarray(block.transpose(1, 0, 2)) for block in blocks]

    def _simulated(self, part: Sequence[int], numbers: Sequence[Number]) -> list[dict[tuple[str, float], np.ndarray]]:
        """The columns of numbers in some units."""
        keys, steps = [self._key(n) for n in numbers], np.array([self._step(n) for n in numbers])
        moved = [
            {**self.values, n.name: self.values.get(n.name, 0.0) + h} for n, (_, h) in zip(numbers, keys, strict=True)
        ]
        if not moved:
            return [{} for _ in part]
        blocks = self.runs.errors([Lane(k, values, self.own[k]) for k in part for values in moved])
        each = [(b - self._base[k][-1][:, None]) / steps[:, None] for k, b in zip(part, blocks, strict=True)]
        return [dict(zip(keys, block.transpose(1, 0, 2), strict=True)) for block in each]

    # ---- and of numbers that share influences
    def _shares(self, number: Number) -> bool:
        return not self._is_bent and number.trial is None and self.runs.places[number.name].kind in SHARED

    def _of_shares(self, k: int, numbers: Sequence[Number]) -> dict[tuple[str, float], np.ndarray]:
        """The columns of numbers that share influences in a unit."""
        if not numbers:
            return {}
        influences = [_influence(self.runs.places[n.name]) for n in numbers]
        slopes = self._slopes_of(k)
        along = np.column_stack([self.runs.share_along(k, n.name, slopes.run) for n in numbers])
        sizes = (np.max(np.abs(along), axis=0) * [STEP * n.sd for n in numbers]).tolist()
        missing = {i: step or 1.0 for i, step in zip(influences, sizes, strict=True) if i not in slopes.by_influence}
        slopes.by_influence.update(self._by_influence(k, slopes.run, missing))
        every = [*slopes.by_influence]
        by_influence = np.stack([slopes.by_influence[i] for i in every], axis=2)
        states = np.empty((len(along), by_influence.shape[1], len(numbers)))
        responses(slopes.by_state, by_influence, np.array([every.index(i) for i in influences]), along, states)
        thrust = np.einsum("kn,knf->kf", slopes.thrust, states)
        columns = self.runs.errors_by(k, states, thrust)
        columns *= np.abs(self._base[k][-1])[:, None] < self.runs.limit[:, None, None]
        return dict(zip([self._key(n) for n in numbers], columns.transpose(1, 0, 2), strict=True))

    def _slopes_of(self, k: int) -> _Slopes:
        if k not in self._slopes:
            run = self.runs.driven(Lane(k, self.values, self.own[k]))
            by_state = slopes_along(*self._with_environment(k, run))
            self._slopes[k] = _Slopes(run, by_state, {}, self.runs.thrust_slopes(run))
        return self._slopes[k]

    def _by_influence(self, k: int, run: Driven, steps: Mapping[Influence, float]) -> dict[Influence, np.ndarray]:
        """Slopes (M, n) of the state a sample ahead by influences; steps : over which each is a difference."""
        if not steps:
            return {}
        model, theta, states, inputs, dt = self._with_environment(k, run)
        changes = list[tuple[np.ndarray, np.ndarray]]()
        for influence, step in steps.items():
            of_inputs, of_numbers = np.zeros(inputs.shape[1]), np.zeros(theta.size)
            if isinstance(influence, int):
                of_inputs[len(model.inputs) + influence] = step
            else:
                places, sizes = zip(*influence, strict=True)
                of_numbers[[*places]] = step * np.array(sizes)
            changes.append((of_inputs, of_numbers))
        ahead = changes_along(model, theta, states, inputs, dt, changes)
        return {i: change / step for (i, step), change in zip(steps.items(), ahead, strict=True)}

    def _with_environment(self, k: int, run: Driven) -> tuple[Model, np.ndarray, np.ndarray, np.ndarray, float]:
        """Model, numbers, states and inputs, with those of the environment, of a unit's run, and its time step."""
        inputs = self.runs.with_environment(run.inputs[0])
        return (
            self.runs.model_at(self.values),
            run.theta[0],
            run.states[0],
            inputs,
            self.runs.units[k].stretch.series.dt,
        )


def _influence(place: Place) -> Influence:
    """What a number changes, apart from its share along the run."""
    return place.inside if place.kind == "regime" else place.column
