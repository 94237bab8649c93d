"""Forces that act for a time in single pieces: a tug, a gust front, a lee, a wave of a passing ship.

No other piece can foretell them, so each piece decides by itself: its errors fall by far more than those of others with
a steady force over a few of its windows.
"""

from __future__ import annotations

from collections.abc import Iterator
from itertools import combinations
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from ...estimation.selection.number import Number
from ...estimation.selection.quadratic import own_step
from ..free_runs.bank import Place
from .catalogue import force_units, forces_of

if TYPE_CHECKING:
    from ...estimation.selection.minimiser import Fitted
    from ..free_runs.problem import FreeRuns

WINDOWS, MOST = 16, 12
"""Windows of a piece, and of them that a force may act over."""
LEAST, ABOVE = 30.0, 8.0
"""Fall of minus twice the log likelihood beside that of the number of trials, and over the median of all pieces."""
HALF = 0.5
"""Share of the pieces that may hold one: else it is the rule, and no event."""


class Event(NamedTuple):
    """A force on an axis over a span of a record, s from its start, with its standard deviation, N or N m.

    fall : of minus twice the log likelihood.  before, after : sums of squared errors (C,) of the piece.
    """

    unit: int
    axis: str
    record: str
    begin_s: float
    end_s: float
    size: float
    sd: float
    fall: float
    before: np.ndarray
    after: np.ndarray


def _with_windows(runs: FreeRuns) -> tuple[FreeRuns, list[Number]]:
    """The runs with a force over each window of a piece on each axis, and their numbers."""
    places = {f"{name[-1]}_window_{i}": Place("window", (str(i), str(WINDOWS)), column)
              for name, column, _ in forces_of(runs.model) for i in range(WINDOWS)}  # fmt: skip
    units = force_units(runs.model, runs.length_s)
    return runs.with_numbers(places, {}), [Number(name, 1e-2 * units[name[0]]) for name in places]


def events(runs: FreeRuns, fitted: Fitted) -> list[Event]:
    """Events of pieces about a fit, those of the largest fall first; none where too many pieces would hold one.

    Eq. 15 of docs/mathematics/pieces.md.
    """
    windowed, numbers = _with_windows(runs)
    axes = [name[-1] for name, *_ in forces_of(runs.model)]
    point = fitted.point
    quadratic = windowed.quadratic(point.values, point.own, numbers)
    each = point.squares / np.maximum(runs.counts, 1.0)
    size = np.sqrt(np.median(each, axis=0) + runs.floor**2)
    normal = quadratic.normal(size)
    best = []
    for k in range(len(runs.units)):
        trials = [t for a in range(len(axes)) for t in _spans(normal.matrix[k], normal.slope[k], a)]
        best.append(max(trials, key=lambda t: t[0]))
    falls = np.array([trial[0] for trial in best])
    bar = max(LEAST + 2.0 * np.log(len(falls) * WINDOWS * MOST * len(axes)), ABOVE * float(np.median(falls)))
    chosen = np.flatnonzero(falls > bar)
    if not chosen.size or chosen.size > HALF * len(falls):
        return []
    out = []
    for k in sorted(chosen.tolist(), key=lambda k: -falls[k]):
        fall, axis, first, last, value, sd = best[k]
        step = np.zeros((len(runs.units), len(numbers)))
        step[k, axis * WINDOWS + first : axis * WINDOWS + last] = value
        after = quadratic.squares(step, own_step(normal, step), range(len(numbers)))[k]
        unit = runs.units[k]
        grid = unit.grid_s - unit.record.time_s[0]
        edges = np.linspace(grid[0], grid[-1], WINDOWS + 1)
        out.append(Event(k, axes[axis], unit.record.name, float(edges[first]), float(edges[last]), value, sd,
                         fall, point.squares[k], after))  # fmt: skip
    return out


def _spans(matrix: np.ndarray, slope: np.ndarray, axis: int) -> Iterator[tuple[float, int, int, int, float, float]]:
    """Fall, axis, first window, window after the last, size and its standard deviation of every span on an axis."""
    own = slice(axis * WINDOWS, (axis + 1) * WINDOWS)
    whole = np.zeros((WINDOWS + 1, WINDOWS + 1))
    whole[1:, 1:] = matrix[own, own].cumsum(axis=0).cumsum(axis=1)
    along = np.concatenate([[0.0], slope[own].cumsum()])
    for first, last in combinations(range(WINDOWS + 1), 2):
        information = whole[last, last] - whole[first, last] - whole[last, first] + whole[first, first]
        if last - first <= MOST and information > 0.0:
            gain = along[last] - along[first]
            yield float(gain**2 / information), axis, first, last, float(gain / information), float(information**-0.5)
