"""How the yaw rate answers the rudder, without a hull model: how clearly, to which side, and how late.

In every hull the rudder acts on the yaw acceleration: r' = a r + c r |r| + b delta(t - lag) + d, at any speed.  A
rudder that was recorded late shows a motion that comes before its order, and no hull can do that.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from ...datasets.signals import sensor_sd
from ...models.linear_algebra import lstsq, pinv

if TYPE_CHECKING:
    from ...datasets.record import Record

MEANS = 200
"""Means over equal stretches of a record, of which slopes are taken."""
FEWEST = 20
"""Samples with yaw rate and rudder below which a record is not used."""
SHOWN = 3.0
"""Times its noise that the slope of the yaw rate must be for it to say anything of a rudder that does nothing."""
FARTHEST = 0.1
"""Share of a record's duration up to which lags are tried, to each side."""


class Response(NamedTuple):
    """b in its standard deviations (starboard positive), share of the remaining square that the rudder takes off, of
    the record as it is; and the same at the lag (s) from order to motion that fits best."""

    z: float
    share: float
    lag_s: float
    z_best: float
    share_best: float
    step_s: float


class _Grid(NamedTuple):
    """Means of one record: slopes of the yaw rate (M,), yaw rate and rudder between them (M,), and the step, s."""

    slope: np.ndarray
    rate: np.ndarray
    rudder: np.ndarray
    step_s: float


def response(records: Sequence[Record]) -> Response | None:
    """The answer of the yaw rate to the rudder in all records together; None without a record that has both."""
    grids = [grid for grid in map(_grid, records) if grid is not None]
    if not grids:
        return None
    z, share, _ = _fitted(grids, 0)
    step = float(np.median([g.step_s for g in grids]))
    farthest = max(int(FARTHEST * min(g.slope.size for g in grids)), 1)
    tried = {k: _fitted(grids, k) for k in range(-farthest, farthest + 1)}
    best = max(tried, key=lambda k: tried[k][1])
    return Response(z, share, best * step, tried[best][0], tried[best][1], step)


def _grid(record: Record) -> _Grid | None:
    """Means of yaw rate (or of the heading's slope) and rudder over stretches of a two-hundredth of the record."""
    time = record.time_s
    if record.has("yaw_rate_rad_s"):
        rate = record.column("yaw_rate_rad_s")
    elif record.has("heading_rad"):
        rate = np.gradient(record.heading_unwrapped(), time)
    else:
        return None
    if not record.has("rudder_rad") and not record.has("rudder_command_rad"):
        return None
    rudder = record.rudder()
    known = np.isfinite(rate) & np.isfinite(rudder)
    if known.sum() < FEWEST:
        return None
    count = min(MEANS, int(known.sum()) // 2)
    rate = np.interp(time, time[known], median_of_three(rate[known]))
    rudder = np.interp(time, time[known], rudder[known])
    even = np.linspace(time[0], time[-1], count * max(record.n // count, 1) + 1)[:-1]
    means = [
        np.interp(even, t, a).reshape(count, -1).mean(axis=1) for t, a in ((time, rate), (time[known], rudder[known]))
    ]
    step = float((time[-1] - time[0]) / count)
    of_rate, of_rudder = (0.5 * (a[1:] + a[:-1]) for a in means)
    return _Grid(np.diff(means[0]) / step, of_rate, of_rudder, step)


def median_of_three(values: np.ndarray) -> np.ndarray:
    """Values (N,) without single ones that stand out."""
    inner = np.median(np.stack([values[:-2], values[1:-1], values[2:]]), axis=0)
    return np.concatenate([values[:1], inner, values[-1:]])


def _fitted(grids: Sequence[_Grid], shift: int) -> tuple[float, float, float]:
    """z and share of the rudder shifted by so many steps, and its coefficient; a constant for each record."""
    rows, target = [], []
    for i, g in enumerate(grids):
        m = g.slope.size
        own = slice(max(shift, 0), m + min(shift, 0))
        earlier = slice(max(-shift, 0), m - max(shift, 0))
        constant = np.zeros((m - abs(shift), len(grids)))
        constant[:, i] = 1.0
        r = g.rate[own]
        rows.append(np.column_stack([g.rudder[earlier], r, r * np.abs(r), constant]))
        target.append(g.slope[own])
    phi, y = np.vstack(rows), np.concatenate(target)
    phi = phi / np.maximum(np.linalg.norm(phi, axis=0), 1e-300)
    b = lstsq(phi, y)
    error = y - phi @ b
    without = y - phi[:, 1:] @ lstsq(phi[:, 1:], y)
    inverse = pinv(phi.T @ phi)
    sd = float(np.sqrt(max(inverse[0, 0], 0.0) * (error @ error) / max(y.size - phi.shape[1], 1)))
    share = 1.0 - float(error @ error) / max(float(without @ without), 1e-300)
    return float(b[0] / max(sd, 1e-300)), share, float(b[0])


def motion_shows(record: Record) -> bool:
    """Whether what the yaw rate leaves of its own slopes stands far above what the noise of its sensor makes them."""
    grid = _grid(record)
    if grid is None:
        return False
    rate = (
        record.column("yaw_rate_rad_s")
        if record.has("yaw_rate_rad_s")
        else np.gradient(record.heading_unwrapped(), record.time_s)
    )
    samples = max(record.n // (grid.slope.size + 1), 1)
    noise = sensor_sd(rate) * np.sqrt(2.0 / samples) / grid.step_s
    r = grid.rate / max(float(np.max(np.abs(grid.rate))), 1e-300)
    phi = np.column_stack([r, r * np.abs(r), np.ones(r.size)])
    left = grid.slope - phi @ lstsq(phi, grid.slope)
    return float(np.std(left)) > SHOWN * noise
