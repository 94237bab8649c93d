"""The linearisation of free runs about a point: how errors change with numbers and with own effects of units.

A column is the difference of two runs over the step of its number; all perturbed runs are lanes of one simulation
(`models.lanes`).  A force along the motion is an input: its column follows from how the state a sample ahead answers
the state and the input, which all forces have in common.  Columns of the model's own numbers, which many fits about
one point share, are kept.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from functools import cached_property
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from ...estimation.selection.quadratic import Quadratic
from ...models.drivers import responses
from ...models.simulate import slopes_along
from .units import Lane

if TYPE_CHECKING:
    from ...estimation.selection.number import Number
    from .problem import FreeRuns

STEP, OWN_STEP = 0.05, 0.3
"""Steps of the differences, in prior standard deviations of numbers and of own effects."""
LANES = 1024
"""Runs that are simulated at once, about: more only need memory."""
FORCES = ("term", "window")
"""Kinds of numbers that are sizes of forces along the motion."""
FEW = 12
"""Forces up to which differences of runs are less work than the slopes along the runs."""
BENDING = ("sensor", "drift", "regime")
"""Kinds of numbers beside which the columns of forces are differences of runs, too."""


class _Slopes(NamedTuple):
    """How a unit's run answers small changes: the state a sample ahead by the state (M, n, n), and by a force on each
    axis (column of the environment's inputs) (M, n);  the thrust by the states (M + 1, n), zero where it is no
    channel."""

    by_state: np.ndarray
    by_force: dict[int, np.ndarray]
    thrust: np.ndarray


class Linearisation:
    """Free runs about a point, as sums of products of the columns of any numbers.

    values : of the numbers by name.  own : effects (K, m) of the units.
    """

    def __init__(self, runs: FreeRuns, values: Mapping[str, float], own: np.ndarray) -> None:
        self.runs, self.values, self.own = runs, dict(values), own
        self._kept: dict[tuple[str, float], list[np.ndarray]] = {}
        self._slopes: dict[int, _Slopes] = {}
        self._are_inputs = not {*BENDING} & {runs.places[name].kind for name, x in values.items() if x}

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
        forces = [n for n in numbers if self._is_force(n)]
        forces = forces if len(forces) > FEW else []
        ready = {*self._kept, *map(self._key, forces)}
        others = [n for n, key in zip(numbers, keys, strict=True) if key not in ready]
        of_model = {self._key(n): list[np.ndarray]() for n in others if runs.places[n.name].kind == "model"}
        grams, count = list[np.ndarray](), max(1, LANES // (len(others) + 1))
        for part in (range(len(self.own))[i : i + count] for i in range(0, len(self.own), count)):
            for k, columns in zip(part, self._simulated(part, others), strict=True):
                columns |= {key: self._kept[key][k] for key in keys if key in self._kept} | self._of_forces(k, forces)
                block = np.stack([*(columns[key] for key in keys), *self._base[k]])
                block = np.ascontiguousarray(block.transpose(1, 0, 2))
                grams.append(block @ block.transpose(0, 2, 1))
                for key, kept in of_model.items():
                    kept.append(columns[key].copy())
        self._kept |= of_model
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

    # ---- and of forces
    def _is_force(self, number: Number) -> bool:
        return self._are_inputs and number.trial is None and self.runs.places[number.name].kind in FORCES

    def _of_forces(self, k: int, forces: Sequence[Number]) -> dict[tuple[str, float], np.ndarray]:
        """The columns of forces in a unit."""
        if not forces:
            return {}
        axes = [self.runs.places[n.name].column for n in forces]
        along = np.column_stack([self.runs.force_along(k, n.name) for n in forces])
        sizes = (np.max(np.abs(along), axis=0) * [STEP * n.sd for n in forces]).tolist()
        slopes = self._slopes_of(k, dict(zip(axes, sizes, strict=True)))
        every = [*slopes.by_force]
        by_force = np.stack([slopes.by_force[axis] for axis in every], axis=2)
        states = np.empty((len(along), by_force.shape[1], len(forces)))
        responses(slopes.by_state, by_force, np.array([every.index(a) for a in axes]), along, states)
        thrust = np.einsum("kn,knf->kf", slopes.thrust, states)
        columns = self.runs.errors_by(k, states, thrust)
        columns *= np.abs(self._base[k][-1])[:, None] < self.runs.limit[:, None, None]
        return dict(zip([self._key(n) for n in forces], columns.transpose(1, 0, 2), strict=True))

    def _slopes_of(self, k: int, steps: Mapping[int, float]) -> _Slopes:
        """The slopes of a unit; steps : axis -> force that its slope is the difference for."""
        own = self._slopes.get(k)
        if own is not None and own.by_force.keys() >= steps.keys():
            return own
        driven, runs = self.runs.driven(Lane(k, self.values, self.own[k])), self.runs
        model, states, theta = runs.model_at(self.values), driven.states[0], driven.theta[0]
        inputs, dt = runs.with_environment(driven.inputs[0]), runs.units[k].stretch.series.dt
        axes = {len(model.inputs) + axis: step or 1.0 for axis, step in steps.items()}
        by_state, by_input = slopes_along(model, theta, states, inputs, dt, axes)
        own = _Slopes(by_state, dict(zip(steps, by_input, strict=True)), runs.thrust_slopes(driven))
        self._slopes[k] = own
        return own
