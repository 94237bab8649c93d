"""A steady drift of the positions against heading and log: a current, where the log measures through the water."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

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
