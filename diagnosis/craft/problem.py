"""Errors of windows as the problem of a fit and of a selection: units are blocks of time, or whole records.

Squares are those of Cauchy's loss with the size s_c of usual errors, so that a stretch which no model explains counts
little,

    rho(e) = (TAIL s_c)^2 log(1 + (e / (TAIL s_c))^2),

and slopes and errors of the linearisation have the weights w = 1/(1 + (e0 / (TAIL s_c))^2) of the errors e0 at its
point: rho(e) is nowhere larger than rho(e0) + w (e^2 - e0^2).  A sample counts as its share of
n_eff, the records' duration over twice the craft's own time: errors within a window are correlated.  Numbers are
differences from the coefficients of the windows' model; those of LINKAGE stand between order and hull.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from copy import copy
from typing import TYPE_CHECKING

import numpy as np

from ...estimation.selection.quadratic import Quadratic
from .windows import Lane, Windows

if TYPE_CHECKING:
    from ...estimation.selection.minimiser import Fitted
    from ...estimation.selection.number import Number

DELAY, SLOWNESS = "rudder_delay", "rudder_slowness"
LINKAGE = {DELAY: ("rudder_delay", 1), SLOWNESS: ("rudder_rate_limit", -1)}
"""Number -> instrument of which it is this power."""
COMMON, OWN = "rudder_offset", "own_angle_"
"""Neutral angle of all records, and that of one beside it, with the record's number."""
TAIL = 4.0
SHARE, NORMAL = 0.95, 1.148
"""Share of the errors whose root mean square is their size, and what makes it that of a normal distribution.  A median
would not do: a craft that lies still half of the time has no error there."""
STEP = 0.02
"""Step of the differences in prior standard deviations."""


class WindowErrors:
    """The errors of windows (`estimation.selection.minimiser.UnitErrors`).

    time_s : the craft's own time;  size : (2,) usual errors of yaw rate and heading.
    """

    def __init__(self, windows: Windows, time_s: float, size: np.ndarray) -> None:
        self.windows, self.size = windows, size
        self.places = {name: i for i, name in enumerate(windows.model.coordinates)}
        self.floor = np.maximum(np.nan_to_num(windows.noise), 1e-3 * windows.motion)
        self.noise, self.known, self.own_sd = np.zeros(2), np.zeros(2, bool), np.zeros(0)
        self._set_units(windows.block)
        independent = max(windows.duration_s / (2.0 * time_s), 4.0)
        self.weight = np.full(len(self.counts), independent / max(float(np.max(self.counts.sum(axis=0))), 1.0))

    def _set_units(self, number: np.ndarray) -> None:
        """Units of the windows (W,) of one number each."""
        self.firsts = np.flatnonzero(np.diff(number, prepend=-1))
        self.counts = np.add.reduceat(self.windows.known.sum(axis=1), self.firsts).astype(float)

    def of_size(self, size: np.ndarray) -> WindowErrors:
        """The same with another size of usual errors."""
        other = copy(self)
        other.size = size
        return other

    def by_record(self) -> WindowErrors:
        """The same with records as units."""
        other = copy(self)
        other._set_units(self.windows.record)
        other.weight = np.full(len(other.counts), self.weight[0])
        return other

    @property
    def channels(self) -> int:
        """Channels that are measured, one or two."""
        return int(np.count_nonzero(self.counts.sum(axis=0)))

    @property
    def no_own(self) -> np.ndarray:
        """Own effects (K, 0) of units: they have none."""
        return np.zeros((len(self.counts), 0))

    # ---- the problem
    def squares(self, values: Sequence[Mapping[str, float]], own: np.ndarray) -> np.ndarray:
        """Sums of squares (K, 2) of each unit at its values of the numbers."""
        return self.sums(self.errors(values))

    def sums(self, errors: np.ndarray) -> np.ndarray:
        """Sums of squares (K, 2) of errors (W, N + 1, 2)."""
        tail = TAIL * self.size
        return np.add.reduceat(np.sum(tail**2 * np.log1p((errors / tail) ** 2), axis=1), self.firsts)

    def errors(self, values: Sequence[Mapping[str, float]]) -> np.ndarray:
        """Errors (W, N + 1, 2) of all windows at the values of their units, 0 in gaps."""
        if all(one is values[0] for one in values):
            return self.windows.errors([self.lane(values[0])])
        ends = [*self.firsts[1:].tolist(), len(self.windows.inputs)]
        units = map(slice, self.firsts.tolist(), ends)
        return self.windows.errors([self.lane(*one) for one in zip(values, units, strict=True)])

    def quadratic(self, values: Mapping[str, float], own: np.ndarray, numbers: Sequence[Number]) -> Quadratic:
        """Linearisation about a point."""
        steps = np.array([n.step(values.get(n.name, 0.0), STEP) for n in numbers])
        moved = [{**values, n.name: values.get(n.name, 0.0) + h} for n, h in zip(numbers, steps.tolist(), strict=True)]
        found = self.windows.errors([self.lane(one) for one in (*moved, values)])
        rows = found.reshape(len(steps) + 1, *self.windows.known.shape)
        at_the_point = self.sums(rows[-1])
        rows[:-1] = (rows[:-1] - rows[-1]) / steps[:, None, None, None]
        rows /= np.sqrt(1.0 + (rows[-1] / (TAIL * self.size)) ** 2)
        columns = np.ascontiguousarray(rows.transpose(1, 3, 0, 2))
        gram = np.add.reduceat(columns @ columns.transpose(0, 1, 3, 2), self.firsts)
        gram[:, :, -1, -1] = at_the_point
        return Quadratic(gram, self.weight, own, self.own_sd)

    def lane(self, values: Mapping[str, float], windows: slice = slice(None)) -> Lane:
        """Windows at values of the numbers."""
        sets = self.coefficients(values)
        shifts = {int(name.removeprefix(OWN)): x for name, x in values.items() if name.startswith(OWN)}
        if shifts:
            sets = np.tile(sets, (len(self.windows.record), 1))
            sets[:, self.places[COMMON]] += [shifts.get(record, 0.0) for record in self.windows.record.tolist()]
        return Lane(sets, tuple(linkage_of(values).items()), windows)

    def coefficients(self, values: Mapping[str, float]) -> np.ndarray:
        """Coefficients (p,) of the model at values of the numbers."""
        sets = self.windows.model.coefficients.copy()
        for name, x in values.items():
            if name in self.places:
                sets[self.places[name]] += x
        return sets

    # ---- of a fit
    def left_out(self, fitted: Fitted) -> np.ndarray:
        """Errors (W, N + 1, 2) of every window by the fit without its unit, nan in gaps."""
        return np.where(self.windows.known, self.errors(fitted.without), np.nan)

    def usual(self, fitted: Fitted) -> np.ndarray:
        """(2,) sizes of the errors of a fit: root mean square of the smallest SHARE, as that of all if they were
        normal; not below what counts as none."""
        errors = np.abs(self.errors([fitted.point.values] * len(self.counts)))
        return np.maximum([_trimmed(errors[:, :, c][self.windows.known[:, :, c]]) for c in range(2)], self.floor)


def linkage_of(values: Mapping[str, float]) -> dict[str, float]:
    """Instruments between order and hull at values of the numbers."""
    return {LINKAGE[n][0]: x ** LINKAGE[n][1] for n, x in values.items() if n in LINKAGE and x > 0.0}


def _trimmed(values: np.ndarray) -> float:
    if not values.size:
        return 1.0
    return NORMAL * float(np.sqrt(np.mean(values[values <= np.quantile(values, SHARE)] ** 2)))
