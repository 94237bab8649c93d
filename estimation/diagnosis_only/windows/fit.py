"""Fits to windows with a robust loss and priors, and errors of blocks of time that were left out.

The criterion is, over windows w, channels c and samples k,

    n_eff sum_c [ log s_c + mean_w mean_k c^2/2 log(1 + (e / (c s_c))^2) ]
        + 1/2 sum ((theta - mean)/sd)^2 + 1/2 sum (shift_i / sd)^2,    c = TAIL,

s_c being the errors' own size (trimmed root mean square, at least the sensor's noise), n_eff the records' duration over
twice the craft's own time: errors within a window are correlated.  Every record has a neutral angle of its own beside
the common one, shift_i.  Cauchy's loss lets a stretch that no model explains count little.  Gauss-Newton
steps with Levenberg's damping; all windows and all derivatives are predicted in one call of the compiled lanes.
Leaving a block of time out subtracts its part of the normal equations and takes one step.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ....models.linear_algebra import lstsq, pinv
from ...selection import score
from ...selection.score import Fall
from .problem import Windows

DIFFERENCE = 1e-3
"""Step of the derivatives in prior standard deviations."""
LONGEST = 1.5
"""Longest step in prior standard deviations."""
ENOUGH = 1e-3
SHARE, NORMAL = 0.95, 1.148
"""Share of the errors whose root mean square is their size, and what makes it that of a normal distribution.  A median
would not do: a craft that lies still half of the time has no error there."""
COMMON = "rudder_offset"
"""The shift of the first input that all records have in common."""
TAIL = 4.0
"""Scale of Cauchy's loss in the errors' own sizes; where the errors of all models that are compared are larger, they
count as this in scores."""
MISSED = 2.0
"""Error, in the root mean square of the motion, of a hard turn that a model misses."""


@dataclass(frozen=True)
class Number:
    """A coefficient that may move: its place, prior mean and standard deviation, and its range."""

    name: str
    place: int
    mean: float
    sd: float
    low: float = -np.inf
    high: float = np.inf


@dataclass(frozen=True, eq=False)
class Fitted:
    """Coefficients (p,), the numbers that were free, each record's shift of the first input (R,), error sizes (2,),
    the criterion, and the normal equations (q + R, q + R) with each block's part of them."""

    windows: Windows
    numbers: tuple[Number, ...]
    coefficients: np.ndarray
    shifts: np.ndarray
    sizes: np.ndarray
    criterion: float
    normal: np.ndarray
    parts: tuple[tuple[np.ndarray, np.ndarray], ...]

    @property
    def values(self) -> np.ndarray:
        """(q,) values of the free numbers."""
        return self.coefficients[[n.place for n in self.numbers]]


def fit(
    windows: Windows,
    numbers: Sequence[Number],
    coefficients: np.ndarray,
    time_s: float,
    shift_sd: float,
    shifts: np.ndarray | None = None,
    most: int = 12,
) -> Fitted:
    """The fit from a start.  time_s : the craft's own time;  shift_sd : of a record's own neutral angle, rad."""
    here = _clipped(np.array(coefficients, float), numbers)
    own = np.zeros(windows.n_records) if shifts is None else shifts
    weight = _weight(windows, time_s)
    for steps in (max(most // 3, 2), max(most // 2, 2), most):
        sizes = _sizes(windows, here, own)
        criterion = _Criterion(windows, tuple(numbers), weight, shift_sd, sizes)
        here, own = _levelled(criterion, *_descended(criterion, here, own, steps))
    last = _Criterion(windows, tuple(numbers), weight, shift_sd, _sizes(windows, here, own))
    normal, _, parts = last.equations(here, own)
    return Fitted(windows, tuple(numbers), here, own, last.sizes, last.value(here, own), normal, parts)


def criterion_at(
    windows: Windows, numbers: Sequence[Number], coefficients: np.ndarray, time_s: float, shift_sd: float
) -> float:
    """The criterion at a start, without a step."""
    here, own = _clipped(np.array(coefficients, float), numbers), np.zeros(windows.n_records)
    sizes = _sizes(windows, here, own)
    return _Criterion(windows, tuple(numbers), _weight(windows, time_s), shift_sd, sizes).value(here, own)


def _weight(windows: Windows, time_s: float) -> float:
    """n_eff: independent errors that the records' duration amounts to, at least four."""
    return max(windows.duration_s / (2.0 * time_s), 4.0)


@dataclass(frozen=True, eq=False)
class _Criterion:
    """The criterion with error sizes (2,) that are held."""

    windows: Windows
    numbers: tuple[Number, ...]
    weight: float
    shift_sd: float
    sizes: np.ndarray

    def value(self, here: np.ndarray, own: np.ndarray) -> float:
        """The criterion at coefficients (p,) and own shifts (R,)."""
        w = self.windows
        error = w.errors(here[None], own[w.record][None]) / self.sizes
        loss = sum(TAIL**2 * _mean(np.log1p((error[:, :, c] / TAIL) ** 2)) for c in range(2))
        prior = sum(((here[n.place] - n.mean) / n.sd) ** 2 for n in self.numbers)
        prior += float(np.sum((own / self.shift_sd) ** 2))
        return float(self.weight * (0.5 * loss + np.sum(np.log(self.sizes))) + 0.5 * prior)

    def equations(
        self, here: np.ndarray, own: np.ndarray
    ) -> tuple[np.ndarray, np.ndarray, tuple[tuple[np.ndarray, np.ndarray], ...]]:
        """Normal equations (q + R, q + R), (q + R,) with priors, and each block's part of them."""
        w, q = self.windows, len(self.numbers)
        square, pull = self._by_window(here, own)
        size = q + w.n_records
        normal, slope, parts = np.zeros((size, size)), np.zeros(size), []
        for block in range(int(w.block.max()) + 1):
            mine, vector = np.zeros((size, size)), np.zeros(size)
            for record in np.unique(w.record[w.block == block]).tolist():
                pick = (w.block == block) & (w.record == record)
                places = np.array([*range(q), q + record])
                mine[np.ix_(places, places)] += square[pick].sum(axis=0)
                vector[places] += pull[pick].sum(axis=0)
            parts.append((mine, vector))
            normal += mine
            slope += vector
        values = np.concatenate([here[[n.place for n in self.numbers]] if q else np.zeros(0), own])
        mean = np.concatenate([[n.mean for n in self.numbers], np.zeros(w.n_records)])
        precision = self.scale**-2.0
        return normal + np.diag(precision), slope - precision * (values - mean), tuple(parts)

    @property
    def scale(self) -> np.ndarray:
        """(q + R,) prior standard deviations."""
        own = np.full(self.windows.n_records, self.shift_sd)
        return np.concatenate([[n.sd for n in self.numbers], own])

    def _by_window(self, here: np.ndarray, own: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Each window's weighted products of slopes (W, q + 1, q + 1), and of slopes with errors (W, q + 1)."""
        w, q, count = self.windows, len(self.numbers), len(self.windows.inputs)
        steps = np.array([DIFFERENCE * n.sd for n in self.numbers] + [DIFFERENCE * self.shift_sd])
        sets, shift = np.tile(here, (q + 2, 1)), np.tile(own[w.record], (q + 2, 1))
        for j, n in enumerate(self.numbers):
            sets[j + 1, n.place] += steps[j]
        shift[q + 1] += steps[q]
        found = w.errors(sets, shift).reshape(q + 2, count, -1, 2)
        error = found[0] / self.sizes
        slopes = (found[1:] - found[:1]) / steps[:, None, None, None] / self.sizes
        known = np.isfinite(error)
        each = self.weight / np.maximum(known.sum(axis=(0, 1)), 1)
        root = np.sqrt(np.where(known, 1.0 / (1.0 + (error / TAIL) ** 2), 0.0) * each)
        target = (np.where(known, error, 0.0) * root).reshape(count, -1)
        rows = (np.where(known, slopes, 0.0) * root).reshape(q + 1, count, -1)
        square = np.einsum("iwk,jwk->wij", rows, rows, optimize=True)
        return square, -np.einsum("iwk,wk->wi", rows, target, optimize=True)


def _descended(c: _Criterion, here: np.ndarray, own: np.ndarray, most: int) -> tuple[np.ndarray, np.ndarray]:
    """Where damped Gauss-Newton steps lead."""
    cost, damping, q = c.value(here, own), 1e-2, len(c.numbers)
    for _ in range(most):
        normal, slope, _ = c.equations(here, own)
        before = cost
        for _ in range(6):
            step = lstsq(normal + damping * np.diag(np.diag(normal)), slope)
            step *= min(1.0, LONGEST / max(float(np.max(np.abs(step) / c.scale)), 1e-12))
            trial, theirs = _moved(here, c.numbers, step), own + step[q:]
            new = c.value(trial, theirs)
            if new < cost:
                here, own, cost, damping = trial, theirs, new, max(damping / 6.0, 1e-6)
                break
            damping *= 6.0
        if before - cost < ENOUGH * max(abs(cost), 1.0):
            break
    return here, own


def _levelled(c: _Criterion, here: np.ndarray, own: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """What the records' own shifts have in common moved to the common one, where that is free: errors stay as they
    are and the priors fall, but along such a line damped steps are short."""
    common = next((n for n in c.numbers if n.name == COMMON), None)
    if common is None:
        return here, own
    mine, theirs = common.sd**-2.0, c.shift_sd**-2.0
    move = (theirs * np.sum(own) - mine * (here[common.place] - common.mean)) / (theirs * own.size + mine)
    level = here.copy()
    level[common.place] += move
    level = _clipped(level, c.numbers)
    moved = own - (level[common.place] - here[common.place])
    return (level, moved) if c.value(level, moved) < c.value(here, own) else (here, own)


def _clipped(coefficients: np.ndarray, numbers: Sequence[Number]) -> np.ndarray:
    out = coefficients.copy()
    for n in numbers:
        out[n.place] = min(max(out[n.place], n.low), n.high)
    return out


def _moved(coefficients: np.ndarray, numbers: Sequence[Number], step: np.ndarray) -> np.ndarray:
    out = coefficients.copy()
    out[[n.place for n in numbers]] += step[: len(numbers)]
    return _clipped(out, numbers)


def _sizes(w: Windows, coefficients: np.ndarray, own: np.ndarray) -> np.ndarray:
    """(2,) sizes of the errors, not below the sensors' noise nor a thousandth of the motion."""
    error = w.errors(coefficients[None], own[w.record][None])
    found = np.array([_trimmed(np.abs(error[:, :, c])) for c in range(2)])
    return np.maximum(np.nan_to_num(found, nan=1.0), np.maximum(np.nan_to_num(w.noise), 1e-3 * w.motion))


def _trimmed(values: np.ndarray) -> float:
    """Root mean square of the smallest SHARE of the values, as that of all if they were normal."""
    known = values[np.isfinite(values)]
    if not known.size:
        return float("nan")
    kept = known[known <= np.quantile(known, SHARE)]
    return NORMAL * float(np.sqrt(np.mean(kept**2)))


def _mean(values: np.ndarray) -> float:
    known = np.isfinite(values)
    return float(values[known].mean()) if known.any() else 0.0


def covariance_of(found: Fitted, shift_sd: float) -> np.ndarray:
    """(q, q) of the free numbers: of the criterion's curvature, and beside it how they differ between blocks of time.

    Along simulated craft either alone is too small by a quarter to a half; intervals of the sum hold about 90 %.
    The curvature knows the records' own shifts only by their prior; here they count as they were found.

    shift_sd : of the shifts beforehand; it counts as one record more.
    """
    q, blocks, shifts = len(found.numbers), len(found.parts), found.shifts
    names = [n.name for n in found.numbers]
    out = pinv(found.normal)[:q, :q]
    if "rudder_offset" in names:
        known = (shift_sd**2 + shifts @ shifts) / (1.0 + shifts.size) / shift_sd**2
        scale = np.where(np.array(names) == "rudder_offset", np.sqrt(min(known, 1.0)), 1.0)
        out *= np.outer(scale, scale)
    if blocks < 4:
        return out
    moved = np.array([lstsq(found.normal - h, -g)[:q] for h, g in found.parts])
    moved -= moved.mean(axis=0)
    return out + (blocks - 1.0) / blocks * moved.T @ moved


def left_out_errors(found: Fitted) -> np.ndarray:
    """Errors (2 W, N + 1, 2) of every window by a fit without its block: with the record's own neutral angle, then
    without one."""
    w, q = found.windows, len(found.numbers)
    scale = np.array([n.sd for n in found.numbers])
    sets, shifts = np.empty((len(w.inputs), found.coefficients.size)), np.empty(len(w.inputs))
    for block, (matrix, vector) in enumerate(found.parts):
        step = lstsq(found.normal - matrix, -vector)
        step *= min(1.0, 2.0 * LONGEST / max(float(np.max(np.abs(step[:q]) / scale, initial=0.0)), 1e-12))
        pick = w.block == block
        sets[pick] = _moved(found.coefficients, found.numbers, step)
        shifts[pick] = (found.shifts + step[q:])[w.record[pick]]
    both = np.stack([shifts, np.zeros_like(shifts)])
    return w.errors(np.stack([sets, sets]), both)


def mean_squares(errors: Sequence[np.ndarray], w: Windows, sizes: np.ndarray) -> np.ndarray:
    """(models, blocks, 2, 2) sums of bounded squared errors and their counts by block and channel.

    errors : (2 W, N + 1, 2) of every model.  What none of them explains counts as TAIL sizes, so that a stretch which
    is nobody's decides nothing; what one explains and another does not counts as it is, up to a turn that is missed.
    """
    size = np.abs(np.stack(list(errors)))
    limit = TAIL * sizes
    size = size * np.minimum(limit / np.maximum(size.min(axis=0), 1e-300), 1.0)
    square = np.minimum(size, np.maximum(limit, MISSED * w.motion)) ** 2
    known = np.isfinite(square)
    half, blocks = len(w.block), int(w.block.max()) + 1
    out = np.zeros((len(square), blocks, 2, 2))
    for place, values in enumerate((np.where(known, square, 0.0), known)):
        total = values.sum(axis=2)
        for model, each in zip(out, total[:, :half] + total[:, half:], strict=True):
            np.add.at(model[:, :, place], w.block, each)
    return out


def fall(old: np.ndarray, new: np.ndarray, w: Windows, sizes: np.ndarray) -> Fall:
    """By how much the logarithm of the root mean square error of left-out blocks falls, mean over channels, and its
    jackknife standard error over blocks, infinite for fewer than three: 0.05 is about 5 %."""
    before, after = mean_squares((old, new), w, sizes)
    count = before[:, :, 1]
    floor = np.maximum(np.nan_to_num(w.noise), 1e-3 * w.motion) ** 2
    by = score.fall(before[:, :, 0], after[:, :, 0], count * floor)
    channels = max(int(np.count_nonzero(count.sum(axis=0))), 1)
    return Fall(by.gain / channels, by.error / channels if len(count) > 2 else np.inf)
