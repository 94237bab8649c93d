"""Surge and sway of a craft beside its yaw, so that the model needs no measured speed.

    u_dot = drive + push n |n| - drag u |u| - turn_drag r^2        thrust against resistance, loss in turns
    sway_time v_dot = -(v + lever r)                               drift about a point ahead

Both are linear in their numbers, once they are integrated over windows of some of the craft's own times: no derivative
of a measured speed is needed.  Yaw rate and revolutions are those of the records.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from scipy.optimize import lsq_linear

from ...estimation.observers.smoothing import smoothed_states
from ...estimation.records.gaps import SHORTEST, parts_of
from ...estimation.records.series import samples

if TYPE_CHECKING:
    from ...datasets.record import Record
    from ...models.model import Model

SURGE, SWAY = 4.0, 1.0
"""Lengths of the windows of surge and of sway, in the craft's own times."""
FEWEST = 12
"""Windows that are needed."""
VARIED = 0.05
"""Spread of the revolutions over their mean, below which they tell nothing."""


class _Motion(NamedTuple):
    """Times, u, v, r and n (N,) of a stretch between long gaps; v is nan, n zero where they were not measured."""

    time: np.ndarray
    u: np.ndarray
    v: np.ndarray
    r: np.ndarray
    n: np.ndarray


def numbers_of(train: Sequence[Record], time_s: float, turns: bool) -> dict[str, float]:
    """The numbers of surge and, where it was measured, sway; none where the records measure no surge.

    time_s : the craft's own time;  turns : whether all records measure revolutions.
    """
    found = list(_stretches(train, time_s))
    if not found:
        return {}
    every = np.concatenate([motion.n for motion in found])
    by_propeller = turns and bool(np.std(every) > VARIED * np.abs(np.mean(every)))
    surge = np.concatenate([_surge_rows(motion, SURGE * time_s) for motion in found])
    sway = np.concatenate([_sway_rows(motion, SWAY * time_s) for motion in found])
    if len(surge) < FEWEST:
        return {}
    free = [0, 1, 2, *([3] if by_propeller else [])]
    values = _bounded(surge[:, free], surge[:, -1], np.array([-np.inf, 0.0, 0.0, 0.0])[free])
    told = dict(zip(("speed_drive", "speed_drag", "turn_drag", "speed_push"), values.tolist(), strict=False))
    lever, lag = 0.0, time_s
    sway = sway[np.isfinite(sway).all(axis=1)]
    if len(sway) >= FEWEST:
        lever, lag = _bounded(sway[:, :2], sway[:, 2], np.array([-np.inf, 0.05 * time_s])).tolist()
    return told | {"sway_lever": lever, "sway_time": lag}


def with_own_speed(model: Model, numbers: dict[str, float]) -> Model:
    """The model with surge and sway of its own."""
    from ...models import kernels

    extra = "own_speed_by_propeller" if "speed_push" in numbers else "own_speed"
    family = f"{model.family}+{extra}"
    known = dict(zip(model.coordinates, model.coefficients.tolist(), strict=True)) | numbers
    values = np.array([known[name] for name in kernels.load(family).COEFFICIENTS])
    return replace(model, family=family, coefficients=values, title=f"{model.title}; surge and sway of its own")


def _stretches(train: Sequence[Record], time_s: float) -> Iterator[_Motion]:
    for record in train:
        for part in parts_of(record, time_s / 20.0):
            states = smoothed_states(part, part.time_s) if part.n >= SHORTEST else {}
            if {"u", "r"} <= set(states):
                turns, v = samples(part, "n"), states.get("v", np.full(part.n, np.nan))
                n = np.zeros(part.n) if turns is None else np.nan_to_num(turns)
                yield _Motion(part.time_s, states["u"], v, states["r"], n)


def _surge_rows(m: _Motion, long_s: float) -> np.ndarray:
    """Rows (W, 5): what drive, drag, turn_drag and push bring over a window, and the change of u."""
    first, last = _windows(m.time, long_s)
    columns = [np.ones(m.time.size), -m.u * np.abs(m.u), -(m.r**2), m.n * np.abs(m.n)]
    return np.column_stack([*(_over(m.time, c, first, last) for c in columns), m.u[last] - m.u[first]])


def _sway_rows(m: _Motion, long_s: float) -> np.ndarray:
    """Rows (W, 3): what the lever and the time bring over a window, and minus the integral of v."""
    first, last = _windows(m.time, long_s)
    drift = _over(m.time, m.v, first, last)
    return np.column_stack([_over(m.time, m.r, first, last), m.v[last] - m.v[first], -drift])


def _windows(time: np.ndarray, long_s: float) -> tuple[np.ndarray, np.ndarray]:
    """Numbers of the first and last samples of windows that overlap by three quarters."""
    starts = np.arange(time[0], time[-1] - long_s, long_s / 4.0)
    first = np.searchsorted(time, starts)
    return first, np.minimum(np.searchsorted(time, starts + long_s), time.size - 1)


def _over(time: np.ndarray, values: np.ndarray, first: np.ndarray, last: np.ndarray) -> np.ndarray:
    """Integrals (W,) of a series (N,) over windows."""
    area = np.concatenate([[0.0], np.cumsum(0.5 * (values[1:] + values[:-1]) * np.diff(time))])
    return area[last] - area[first]


def _bounded(rows: np.ndarray, target: np.ndarray, low: np.ndarray) -> np.ndarray:
    """Least squares above lower bounds, columns at equal size."""
    size = np.maximum(np.sqrt(np.mean(rows**2, axis=0)), 1e-300)
    return lsq_linear(rows / size, target, (low * size, np.inf)).x / size
