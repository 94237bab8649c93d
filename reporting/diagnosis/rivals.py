"""A craft's model beside the two that anyone would try first, on the same windows of held-out records.

    Nomoto   T r_dot + r = K (delta(t - tau) + delta_0)
    ARX      r_k = a_1 r_(k-1) + ... + b_0 delta_(k-d) + ... + c

Both are fitted to the yaw rate of the training records.  Time constant and delay of the first are those of the smallest
squared error over windows; orders and delay of the second are those whose free runs have the smallest squared error
over windows of training records (or of quarters of the only one) that the regression has not seen.
Source: Nomoto 1960; Ljung 1999, System Identification, section 4.2.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import product
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from scipy.signal import lfilter

from ...diagnosis.craft.records import without_spikes
from ...diagnosis.craft.windows import pieces_of, scales_of, windows_of
from ...models.linear_algebra import lstsq
from ...models.model import resolve

if TYPE_CHECKING:
    from ...datasets.record import Record
    from ...diagnosis.craft.windows import Scales
    from ...models.model import Model

HISTORY = 12
"""Samples before a window that the difference equation may look back at."""
TIMES = np.geomspace(0.1, 100.0, 40)
"""Time constants that are tried, in steps of the windows."""
DELAYS = (0.0, 0.5, 1.0, 1.5, 2.0, 3.0, 4.0, 5.0, 6.0, 8.0, 10.0, 12.0)
ORDERS = tuple(product((1, 2, 3, 4), (1, 2, 3, 4), (0, 1, 2, 3, 4, 6, 8)))
"""Values of the yaw rate and of the rudder, and delays in steps, that are tried."""
OVERLAP = 10
"""Windows of held-out records that begin within one."""
PARTS = 4
"""Parts of a single record that are left out in turn."""


class YawRateSkill(NamedTuple):
    """R2 of the yaw rate over the windows, of the craft's model and of the two others; length [s] and number of the
    windows."""

    craft: float
    nomoto: float
    arx: float
    window_s: float
    windows: int


@dataclass(frozen=True)
class Stretches:
    """Windows of N steps with their history: rudder, measured (nan: gap) and smoothed yaw rate (W, HISTORY + N + 1);
    the part of the records (W,) that each belongs to; which of all windows they are (W,)."""

    rudder: np.ndarray
    rate: np.ndarray
    smooth: np.ndarray
    part: np.ndarray
    place: np.ndarray

    def of(self, keep: np.ndarray) -> Stretches:
        """Some of the windows."""
        return Stretches(*(values[keep] for values in (self.rudder, self.rate, self.smooth, self.part, self.place)))

    @property
    def ahead(self) -> np.ndarray:
        """Measured yaw rate (W, N) after the start."""
        return self.rate[:, HISTORY + 1 :]


def compared(model: Model, train: Sequence[Record], held_out: Sequence[Record]) -> YawRateSkill:
    """The model of a craft's diagnosis beside the two, all of them from the training records."""
    train, held_out = ([without_spikes(r.turned("starboard"))[0] for r in side] for side in (train, held_out))
    scales = scales_of(train)
    seen, new = stretches_of(train, scales), stretches_of(held_out, scales, OVERLAP)
    windows = windows_of(pieces_of(held_out, scales), model, scales, OVERLAP)
    own = windows.errors_of(model)[new.place, 1:, 0]
    errors = (own, nomoto_errors(nomoto(seen), new), arx_errors(arx(seen), new))
    return YawRateSkill(*(_r2(e, new.ahead) for e in errors), windows.length_s, len(own))


def stretches_of(records: Sequence[Record], scales: Scales, overlap: int | None = None) -> Stretches:
    """The windows of records that have a history, of the craft's own length;  overlap : as of `windows_of`."""
    windows = windows_of(pieces_of(records, scales), resolve("nomoto-1"), scales, overlap)
    single, found = len(records) == 1, []
    for stretch in windows.stretches:
        for row, first in enumerate(stretch.firsts.tolist(), stretch.place):
            if first >= HISTORY:
                part = first * PARTS // len(stretch.grid_s) if single else int(windows.record[row])
                span = slice(first - HISTORY, first + windows.inputs.shape[1])
                found.append((*(x[span, 0] for x in (stretch.inputs, stretch.measured, stretch.smooth)), part, row))
    return Stretches(*(np.array(column) for column in zip(*found, strict=True)))


class Nomoto(NamedTuple):
    """Time constant and delay in steps, gain, and gain times the rudder's offset."""

    steps: float
    delay: float
    gain: float
    turning: float


def nomoto(of: Stretches) -> Nomoto:
    """The first-order model of the smallest squared error."""
    known, tried = np.isfinite(of.ahead), []
    for steps, delay in product(TIMES.tolist(), DELAYS):
        free, *columns = _responses(of, steps, delay)
        rows, rest = np.stack([c[known] for c in columns], axis=1), (of.ahead - free)[known]
        values = lstsq(rows, rest)
        tried.append((float(np.sum((rest - rows @ values) ** 2)), Nomoto(steps, delay, *values.tolist())))
    return min(tried)[1]


def nomoto_errors(model: Nomoto, of: Stretches) -> np.ndarray:
    """Predicted minus measured yaw rate (W, N)."""
    free, by_rudder, constant = _responses(of, model.steps, model.delay)
    return free + model.gain * by_rudder + model.turning * constant - of.ahead


def _responses(of: Stretches, steps: float, delay: float) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """What the start, a unit of the rudder, and a steady unit bring to the yaw rate (W, N)."""
    decay, whole = np.exp(-1.0 / steps), int(delay)
    late = [of.rudder[:, HISTORY - k : of.rudder.shape[1] - k] for k in (whole, min(whole + 1, HISTORY))]
    rudder = late[0] + (delay - whole) * (late[1] - late[0])
    drive = (1.0 - decay) * 0.5 * (rudder[:, 1:] + rudder[:, :-1])
    fading = decay ** np.arange(1, rudder.shape[1])
    by_rudder = np.asarray(lfilter([1.0], [1.0, -decay], drive, axis=1))
    return of.smooth[:, HISTORY, None] * fading, by_rudder, np.broadcast_to(1.0 - fading, by_rudder.shape)


class Arx(NamedTuple):
    """Coefficients of the last values of the yaw rate, newest first, then of the rudder, and the constant; delay."""

    rates: np.ndarray
    rudders: np.ndarray
    constant: float
    delay: int


def arx(of: Stretches) -> Arx:
    """The difference equation whose free runs predict left-out parts best, fitted to all."""
    tried = [(sum(_left_out(of, order)), order) for order in ORDERS]
    return _arx(of, min(tried)[1])


def _left_out(of: Stretches, order: tuple[int, int, int]) -> list[float]:
    """Sums of squared errors of every part, by a fit to the others."""
    parts = np.unique(of.part).tolist()
    fits = [(_arx(of.of(of.part != part), order), of.of(of.part == part)) for part in parts if len(parts) > 1]
    return [float(np.nansum(arx_errors(model, rest) ** 2)) for model, rest in fits or [(_arx(of, order), of)]]


def _arx(of: Stretches, order: tuple[int, int, int]) -> Arx:
    """Least squares on one step ahead."""
    rates, rudders, delay = order
    places = np.arange(HISTORY + 1, of.rate.shape[1])
    columns = [of.rate[:, places - 1 - lag].ravel() for lag in range(rates)]
    columns += [of.rudder[:, places - delay - lag].ravel() for lag in range(rudders)]
    rows, target = np.stack([*columns, np.ones(columns[0].size)], axis=1), of.ahead.ravel()
    known = np.isfinite(rows).all(axis=1) & np.isfinite(target)
    values = lstsq(rows[known], target[known])
    return Arx(values[:rates], values[rates:-1], float(values[-1]), delay)


def arx_errors(model: Arx, of: Stretches) -> np.ndarray:
    """Predicted minus measured yaw rate (W, N) of free runs, from the smoothed yaw rate up to the start."""
    run = of.smooth[:, : HISTORY + 1].copy()
    limit = 10.0 * np.max(np.abs(of.smooth))
    for k in range(HISTORY + 1, of.rate.shape[1]):
        past = run[:, ::-1][:, : model.rates.size] @ model.rates
        rudder = of.rudder[:, [k - model.delay - lag for lag in range(model.rudders.size)]] @ model.rudders
        run = np.column_stack([run, np.clip(past + rudder + model.constant, -limit, limit)])
    return run[:, HISTORY + 1 :] - of.ahead


def _r2(errors: np.ndarray, measured: np.ndarray) -> float:
    known = np.isfinite(errors)
    return 1.0 - float(np.sum(errors[known] ** 2) / np.sum((measured[known] - measured[known].mean()) ** 2))
