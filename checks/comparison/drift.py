"""What drifts show.  A steady drift of the positions against heading and log: a current, where the log measures through
the water.  And the drift angle against the heading: a compass that deviates, a current, or leeway.

A ship drifts because it turns, to the other side in the other turn; what of the drift angle goes with the compass
heading instead, v = U (c cos psi + s sin psi), comes from the compass, or from wind or current.  No hull is assumed but
one that is alike on both sides: sway from the yaw rate is estimated along, for each record.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from ...datasets.columns import HEADING, VELOCITIES
from ...datasets.signals import bridged
from ..result import Size
from ..sensors import CurrentDrift
from ..tails import student_quantile
from .blocks import BLOCKS, Rows, Sums, explained, fit, p_value, sums_of
from .chains import Chain, Option, rows_of
from .selection import LEVEL, TIE

if TYPE_CHECKING:
    from ...datasets.record import Record


class Drift(NamedTuple):
    """Drift of one record: name, velocity north and east (2,) m/s, covariance (2, 2), p-value."""

    record: str
    velocity: np.ndarray
    covariance: np.ndarray
    p: float


def drifts(chain: Chain, records: Sequence[Record], chosen: Sequence[Option]) -> list[Drift]:
    """Steady drift of each record (corrected for `chosen`), estimated with what is left of the chosen effects."""
    out = []
    for record in records:
        part = _with_drift(chain, record, chosen)
        one = fit([part], range(part.score.shape[1]))
        at = list(range(one.values.size - 2, one.values.size))
        out.append(Drift(record.name, one.values[at], one.covariance[np.ix_(at, at)], p_value(one, at)))
    return out


def _with_drift(chain: Chain, record: Record, options: Sequence[Option]) -> Sums:
    """Sums of a record's rows with the drift, north and east, as the last two effects."""
    rows, place = rows_of(chain, record, options)
    return sums_of(Rows(rows.y, np.hstack([rows.x, rows.z]), np.zeros((rows.y.size, 0))), place)


def is_there(drifts: Sequence[Drift]) -> bool:
    """Whether a record drifts beyond chance."""
    return bool(drifts) and min(d.p for d in drifts) < LEVEL / len(drifts)


def rivals(chain: Chain, records: Sequence[Record], options: Sequence[Option]) -> list[tuple[Option, float]]:
    """Sensor errors that explain the drifts about as well, best first, with their lead over separate drifts (twice
    the log likelihood, blocks' scatter allowed for)."""
    own = [o for o in options if o.cause.id in CurrentDrift.track_rivals]
    parts = [_with_drift(chain, record, own) for record in records]
    n = len(own)
    whole = sum(explained([p], [n, n + 1]) for p in parts)
    scale = _scatter(parts, [n, n + 1])
    leads = [(o, (explained(parts, [i]) - whole) / scale) for i, o in enumerate(own)]
    return sorted((x for x in leads if x[1] > -TIE), key=lambda x: -x[1])


def _scatter(parts: Sequence[Sums], active: Sequence[int]) -> float:
    return max(float(np.median([np.max(fit([p], active).inflation) for p in parts])), 1.0)


def interval(drift: Drift) -> tuple[float, float, float, float]:
    """Speed m/s with its 90 % interval, and the direction (rad) towards which it goes."""
    speed = float(np.hypot(*drift.velocity))
    along = drift.velocity / max(speed, 1e-300)
    half = float(student_quantile(0.95, BLOCKS - 2) * np.sqrt(max(along @ drift.covariance @ along, 0.0)))
    return speed, max(speed - half, 0.0), speed + half, float(np.arctan2(drift.velocity[1], drift.velocity[0]))


NEEDED = (HEADING, *VELOCITIES)
LEAST_RANGE = np.pi
"""Range of headings (rad) over all records from which the pattern is told from a mean drift."""
SLOW = 0.3
"""Share of the largest speed below which a drift angle says nothing."""
MEANS = 120
"""Means over equal stretches that a record is reduced to."""
FEWEST = 15
"""Means with way on below which a record is not used."""
FLOOR = 0.05
"""Amplitude (rad) from which a deviation matters."""
SHARE = 0.2
"""Share of the sway that turning leaves unexplained which the pattern must explain."""
LAGS = (0.5, 2.0)
"""Time constants with which the sway follows the yaw rate, in times in which the ship changes its turn."""
DEVIATION, STREAM = [0, 1], [2, 3]


class Deviation(NamedTuple):
    """Pattern of the drift angle: names of records, sizes c and s, z, whether a current explains it about as well."""

    records: tuple[str, ...]
    sizes: tuple[Size, ...]
    amplitude: float
    z: float
    share: float
    like_current: bool


def deviation(records: Sequence[Record]) -> Deviation | None:
    """The compass deviation that the drift angles of all records show together; None where there is none.

    It must be there whether the sway follows the yaw rate at once or with lags: a ship in its first turn, which sways
    late, shows a pattern of the heading else.
    """
    usable = [r for r in records if r.has(*NEEDED) and np.isfinite(r.column("sway_m_s")).sum() > MEANS]
    if not usable or _pattern(usable, LAGS) is None:
        return None
    return _pattern(usable, ())


def _pattern(records: Sequence[Record], lags: Sequence[float]) -> Deviation | None:
    """The pattern that records show beside a sway that follows the yaw rate at once and with lags."""
    parts, headings, names = [], [], []
    for record in records:
        rows, place, heading = _rows(record, lags)
        if rows.y.size >= FEWEST:
            parts.append(sums_of(rows, place))
            headings.append(heading)
            names.append(record.name)
    if not parts or _range(np.concatenate(headings)) < LEAST_RANGE:
        return None
    parts = _standardised(parts)
    pattern = fit(parts, DEVIATION)
    share = explained(parts, DEVIATION) / max(sum(p.square for p in parts), 1e-300)
    if p_value(pattern, DEVIATION) > LEVEL or share < SHARE:
        return None
    spread = np.sqrt(np.diag(pattern.covariance))
    half = student_quantile(0.95, max(pattern.blocks - 2, 1)) * spread
    values = -pattern.values
    sizes = tuple(
        Size(n, float(v), float(v - h), float(v + h), "rad") for n, v, h in zip("cs", values, half, strict=True)
    )
    lead = _chance(parts, STREAM) - _chance(parts, DEVIATION)
    z = float(np.max(np.abs(values) / np.maximum(spread, 1e-300)))
    return Deviation(tuple(names), sizes, float(np.hypot(*values)), z, share, lead < TIE)


def _standardised(parts: Sequence[Sums]) -> list[Sums]:
    """The sums in units of what the pattern leaves: rows of about unit variance."""
    rows = max(sum(p.count for p in parts) - len(DEVIATION), 1)
    left = max(sum(p.square for p in parts) - explained(parts, DEVIATION), 1e-300) / rows
    return [Sums(p.gram / left, p.score / left, p.square / left, p.count) for p in parts]


def _chance(parts: Sequence[Sums], columns: list[int]) -> float:
    """Rows that count as independent times the logarithm of what the columns leave; a current is the same in all."""
    rows, square = sum(p.count for p in parts), sum(p.square for p in parts)
    inflation = float(np.max(fit(parts, columns).inflation))
    return rows / inflation * float(np.log(max(square - explained(parts, columns), 1e-300)))


def _rows(record: Record, lags: Sequence[float]) -> tuple[Rows, np.ndarray, np.ndarray]:
    """Rows of a record's means where it makes way, where they stand, and the headings there."""
    time = record.time_s - record.time_s[0]
    heading = bridged(record.heading_unwrapped(), time)
    u, v = bridged(record.column("surge_m_s"), time), bridged(record.column("sway_m_s"), time)
    window = max(time.size // MEANS, 1)
    n = time.size // window * window
    time, heading, u, v = (a[:n].reshape(-1, window).mean(axis=1) for a in (time, heading, u, v))
    rate = np.gradient(heading, time)
    fast = u > SLOW * float(np.max(u))
    pattern = [u * np.cos(heading), u * np.sin(heading), -np.sin(heading), np.cos(heading)]
    turning = _of_turning(time, rate, lags)
    rows = Rows(v[fast], np.stack(pattern, axis=1)[fast], np.stack(turning, axis=1)[fast])
    return rows, (time / max(time[-1], 1e-12))[fast], heading[fast]


def _of_turning(time: np.ndarray, rate: np.ndarray, lags: Sequence[float]) -> list[np.ndarray]:
    """Columns (N,) of the sway that a turn causes: at once, and after lags."""
    from scipy.signal import lfilter

    slope = np.gradient(rate, time)
    turning_time = float(np.sqrt(np.mean(rate**2) / max(float(np.mean(slope**2)), 1e-300)))
    left = [float(np.exp(-np.median(np.diff(time)) / max(lag * turning_time, 1e-300))) for lag in lags]
    after = [np.asarray(lfilter([1.0 - a], [1.0, -a], rate)) for a in left]
    return [rate, rate * np.abs(rate), slope, *after]


def _range(headings: np.ndarray) -> float:
    """Part of the compass (rad) that headings cover: the circle less the largest gap between them."""
    around = np.sort(np.mod(headings, 2.0 * np.pi))
    gaps = np.diff(np.concatenate([around, [around[0] + 2.0 * np.pi]]))
    return float(2.0 * np.pi - gaps.max())
