"""Forces that act for a time in single pieces: a tug, a gust front, a lee, a wave of a passing ship.

No other piece can foretell them, so each piece decides by itself: its errors fall by far more than those of others with
a steady force over a few of its windows.
"""

from __future__ import annotations

from collections.abc import Iterator
from itertools import combinations
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from ...estimation.selection.minimiser import prior_of
from ...estimation.selection.number import Number
from ...estimation.selection.quadratic import own_step
from ..free_runs.bank import Place
from .catalogue import force_units, forces_of

if TYPE_CHECKING:
    from collections.abc import Sequence

    from ...estimation.selection.minimiser import Fitted
    from ..free_runs.motion import Motion, Series
    from ..free_runs.problem import FreeRuns

WINDOWS, MOST = 16, 12
"""Windows of a piece, and of them that a force may act over."""
SLOTS = 48
"""Parts of the longest record that a force which acts in all records at the same time may begin and end at."""
LEAST, ABOVE = 30.0, 8.0
"""Fall of minus twice the log likelihood beside that of the number of trials, and over the median of all pieces."""
MATTERS = 0.02
"""Error of a piece beyond what is no matter, as a share of the motion, from which an event in it is looked for."""
NO_FALL = (0.0, 0, 0, 1, 0.0, np.inf)
"""What a piece shows whose errors no force acts on: runs that have diverged."""
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
        trials = [t for a in range(len(axes)) for t in _of_piece(normal.matrix[k], normal.slope[k], a)]
        best.append(max(trials, key=lambda t: t[0], default=NO_FALL))
    falls = np.array([trial[0] for trial in best])
    bar = max(LEAST + 2.0 * np.log(len(falls) * WINDOWS * MOST * len(axes)), ABOVE * float(np.median(falls)))
    wrong = np.array([np.any(runs.beyond(errors, [k]) > MATTERS**2) for k, errors in enumerate(each)])
    chosen = np.flatnonzero((falls > bar) & wrong)
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


def _of_piece(matrix: np.ndarray, slope: np.ndarray, axis: int) -> Iterator[tuple[float, int, int, int, float, float]]:
    """Fall, axis, first window, window after the last, size and its standard deviation of every span on an axis."""
    own = slice(axis * WINDOWS, (axis + 1) * WINDOWS)
    for fall, first, last, information, along in _spans(matrix[own, own], slope[own]):
        if last - first <= MOST:
            yield fall, axis, first, last, along / information, information**-0.5


def _spans(matrix: np.ndarray, slope: np.ndarray) -> Iterator[tuple[float, int, int, float, float]]:
    """Fall, first window, window after the last, information and slope of a steady force over every span of windows."""
    whole = np.zeros((slope.size + 1, slope.size + 1))
    whole[1:, 1:] = matrix.cumsum(axis=0).cumsum(axis=1)
    total = np.concatenate([[0.0], slope.cumsum()])
    for first, last in combinations(range(slope.size + 1), 2):
        information = float(whole[last, last] - whole[first, last] - whole[last, first] + whole[first, first])
        along = float(total[last] - total[first])
        if information > 0.0:
            yield along**2 / information, first, last, information, along


def common_spans(runs: FreeRuns, fitted: Fitted, always: Sequence[Number]) -> list[tuple[str, float, float]]:
    """For each axis the span of time, s from the start of every record, over which a steady force in all records would
    explain most about a fit, beside numbers that are always free.

    Eq. 15 of docs/mathematics/pieces.md over all pieces together.
    """
    longest_s = max(float(m.past_s[-1]) for m in runs.motions.values())
    edges = np.linspace(0.0, longest_s, SLOTS + 1)
    own = [(name[-1], column) for name, column, _ in forces_of(runs.model)]
    units, held = force_units(runs.model, runs.length_s), len(always)
    names = {f"{axis}_slot_{i}": (axis, column, i) for axis, column in own for i in range(SLOTS)}
    series = {name: _slot(float(edges[i]), float(edges[i + 1])) for name, (*_, i) in names.items()}
    slots = runs.with_numbers({n: Place("term", (n,), column) for n, (_, column, _) in names.items()}, series)
    point, numbers = fitted.point, [*always, *(Number(n, 1e-2 * units[axis]) for n, (axis, *_) in names.items())]
    normal = slots.quadratic(point.values, point.own, numbers).normal(point.size, point.weight)
    matrix, slope = normal.matrix.sum(axis=0), normal.slope.sum(axis=0)
    prior = prior_of(always, point.values)
    across = matrix[:held, held:]
    taken = np.linalg.solve(matrix[:held, :held] + np.diag(prior.sd**-2.0), across)
    rest, along = matrix[held:, held:] - across.T @ taken, slope[held:] - taken.T @ slope[:held]
    out = []
    for number, (axis, _) in enumerate(own):
        part = slice(number * SLOTS, (number + 1) * SLOTS)
        every = (t for t in _spans(rest[part, part], along[part]) if t[2] - t[1] < SLOTS)
        _, first, last, *_ = max(every, default=(0.0, 0, SLOTS, 0.0, 0.0))
        out.append((axis, float(edges[first]), float(edges[last]) if last < SLOTS else np.inf))
    return out


def _slot(begin_s: float, end_s: float) -> Series:
    def inside(motion: Motion) -> np.ndarray:
        return ((motion.past_s >= begin_s) & (motion.past_s < end_s)).astype(float)

    return inside
