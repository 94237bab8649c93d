"""What drifts show.  A steady drift of the positions against heading and log: a current, where the log measures through
the water.  And the drift angle against the heading: a compass that deviates, a current, or leeway.

A ship drifts because it turns, to the other side in the other turn; what of the drift angle goes with the compass
heading instead, v = U (c cos psi + s sin psi), comes from the compass, or from wind or current.  No hull is assumed but
one that is alike on both sides: sway from the yaw rate is estimated along, for each record.
"""

from __future__ import annotations

from collections.abc import Collection, Sequence
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from ...datasets.columns import HEADING, VELOCITIES
from ...datasets.signals import bridged
from ...models.errors import CannotFit
from ..registry import sensor_errors
from ..result import CheckFinding, Size
from ..sensors import CompassDeviation, CurrentDrift, HeadingOffsetError
from ..tails import student_quantile
from .blocks import BLOCKS, Sums, explained, fit, p_value, sums_of
from .chains import Chain, Option, rows_of
from .selection import LEVEL, TIE, Compared

if TYPE_CHECKING:
    from ...datasets.record import Record

DRIFT_SHARE = 0.005
"""Share of the ship's speed from which a drift matters."""


class Drift(NamedTuple):
    """Drift of one record: name, speed m/s, half of its 90 % interval, direction (rad) towards which it goes, p."""

    record: str
    speed: float
    half: float
    towards: float
    p: float

    @property
    def sizes(self) -> tuple[Size, Size]:
        """Speed and direction with their intervals."""
        low, high = self.interval
        turn = min((high - low) / (2.0 * max(self.speed, 1e-300)), np.pi)
        return (
            Size("speed", self.speed, low, high, "m/s", self.record),
            Size("towards", self.towards, self.towards - turn, self.towards + turn, "rad", self.record),
        )

    @property
    def interval(self) -> tuple[float, float]:
        """Least and largest speed, m/s."""
        return max(self.speed - self.half, 0.0), self.speed + self.half


def current_finding(done: Compared) -> CheckFinding | None:
    """A steady drift of the records beyond chance, or the sensor error that explains it with fewer numbers.

    Raises
    ------
    CannotFit : no sea drifts so fast.
    """
    chain, entry = done.chain, CurrentDrift()
    chosen = [s.option for s in done.sizes if s.material]
    drifts = [_drift(chain, record, chosen) for record in done.corrected]
    if not drifts or min(d.p for d in drifts) >= LEVEL / len(drifts):
        return None
    columns = [n for n in VELOCITIES if n in chain.integrated]
    speeds = [float(np.linalg.norm([np.nanmean(r.column(n)) for n in columns])) for r in done.records]
    near = [] if chosen else _rivals(chain, done.corrected, chain.options)
    tied = [o.cause.id for o, _ in near]
    tied += [name for name in entry.track_rivals if not chosen and len(drifts) == 1 and name not in tied]
    rivals_of = {error.id: error.track_rivals for error in sensor_errors()}
    best = min(drifts, key=lambda d: d.p)
    low, high = best.interval
    if best.speed > entry.farthest:
        raise CannotFit(f"the positions of {best.record} would drift by {best.speed:.3g} m/s against heading and log")
    said = (
        f"positions drift against heading and log by {best.speed:.3g} m/s [{low:.3g}, {high:.3g}] towards "
        f"{np.rad2deg(best.towards) % 360.0:.0f} deg in {best.record}: a current, if the log measures through the water"
    )
    if near and near[0][1] > -TIE and len(drifts) > 1:
        said += f"; one {near[0][0].cause.id} for all records explains it as well"
    return CheckFinding(
        entry.id,
        "sensors",
        tuple(d.record for d in drifts),
        chain.needed,
        tuple(size for d in drifts for size in d.sizes),
        said,
        tuple(dict.fromkeys(x for name in tied for x in (name, *rivals_of.get(name, ())))),
        entry.separate_by,
        any(d.speed > DRIFT_SHARE * v for d, v in zip(drifts, speeds, strict=True)),
    )


def _drift(chain: Chain, record: Record, chosen: Sequence[Option]) -> Drift:
    """Steady drift of a record (corrected for `chosen`), estimated with what is left of the chosen effects."""
    part = _with_drift(chain, record, chosen)
    one = fit([part], range(part.score.shape[1]))
    at = list(range(one.values.size - 2, one.values.size))
    velocity, covariance = one.values[at], one.covariance[np.ix_(at, at)]
    speed = float(np.hypot(*velocity))
    along = velocity / max(speed, 1e-300)
    half = float(student_quantile(0.95, BLOCKS - 2) * np.sqrt(max(along @ covariance @ along, 0.0)))
    return Drift(record.name, speed, half, float(np.arctan2(velocity[1], velocity[0])), p_value(one, at))


def _with_drift(chain: Chain, record: Record, options: Sequence[Option]) -> Sums:
    """Sums of a record's rows with the drift, north and east, as the last two effects."""
    rows, place, _ = rows_of(chain, record, options)
    return sums_of(rows, place)


def _rivals(chain: Chain, records: Sequence[Record], options: Sequence[Option]) -> list[tuple[Option, float]]:
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


def deviation_finding(records: Sequence[Record], causes: Collection[str]) -> CheckFinding | None:
    """The compass deviation that the drift angles of all records show together; None where there is none.

    causes : that are told of the records; where a heading is off, the log may stand askew instead, and show one
    drift angle on every heading.

    It must be there whether the sway follows the yaw rate at once or with lags: a ship in its first turn, which sways
    late, shows a pattern of the heading else.
    """
    askew = bool({HeadingOffsetError.id, *HeadingOffsetError.track_rivals} & {*causes})
    usable = [r for r in records if r.has(*NEEDED) and np.isfinite(r.column("sway_m_s")).sum() > MEANS]
    if not usable or _pattern(usable, LAGS, askew) is None:
        return None
    return _pattern(usable, (), askew)


def _pattern(records: Sequence[Record], lags: Sequence[float], askew: bool) -> CheckFinding | None:
    """The pattern that records show beside a sway that follows the yaw rate at once and with lags."""
    parts, headings, names = [], [], []
    for record in records:
        rows, place, heading = _rows(record, lags, askew)
        if place.size >= FEWEST:
            parts.append(sums_of(rows, place, len(rows) - 5))
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
    amplitude, z = float(np.hypot(*values)), float(np.max(np.abs(values) / np.maximum(spread, 1e-300)))
    said = (
        f"the drift angle goes with the heading, by up to {np.rad2deg(amplitude):.2g} deg ({z:.1f} standard errors); "
        f"that explains {100.0 * share:.0f} % of the sway that turning leaves; leeway would look alike"
    )
    sizes = (Size(n, float(v), float(v - h), float(v + h), "rad") for n, v, h in zip("cs", values, half, strict=True))
    like_current = _worse_than(parts, STREAM, DEVIATION) < TIE  # a current is the same at any speed of the ship
    return CheckFinding(
        CompassDeviation.id,
        "sensors",
        tuple(names),
        NEEDED,
        tuple(sizes),
        said,
        ("wind", "current") if like_current else ("wind",),
        CompassDeviation.separate_by,
        amplitude > FLOOR,
        z,
    )


def _standardised(parts: Sequence[Sums]) -> list[Sums]:
    """The sums in units of what the pattern leaves: rows of about unit variance."""
    rows = max(sum(p.count for p in parts) - len(DEVIATION), 1)
    left = max(sum(p.square for p in parts) - explained(parts, DEVIATION), 1e-300) / rows
    return [Sums(p.gram / left, p.score / left, p.square / left, p.count) for p in parts]


def _worse_than(parts: Sequence[Sums], columns: list[int], others: list[int]) -> float:
    """Rows that count as independent times the logarithm of what columns leave over what others leave."""
    rows, square = sum(p.count for p in parts), sum(p.square for p in parts)
    inflation = max(float(np.max(fit(parts, own).inflation)) for own in (columns, others))
    left, least = (max(square - explained(parts, own), 1e-300) for own in (columns, others))
    return rows / inflation * float(np.log(left / least))


def _rows(record: Record, lags: Sequence[float], askew: bool) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Rows of a record's means where it makes way (sway, four patterns of the heading, sway of turning), where they
    stand, and the headings there."""
    time = record.time_s - record.time_s[0]
    heading = bridged(record.heading_unwrapped(), time)
    u, v = bridged(record.column("surge_m_s"), time), bridged(record.column("sway_m_s"), time)
    window = max(time.size // MEANS, 1)
    n = time.size // window * window
    time, heading, u, v = (a[:n].reshape(-1, window).mean(axis=1) for a in (time, heading, u, v))
    rate = np.gradient(heading, time)
    fast = u > SLOW * float(np.max(u))
    pattern = [u * np.cos(heading), u * np.sin(heading), -np.sin(heading), np.cos(heading)]
    turning = [*([u] if askew else []), *_of_turning(time, rate, lags)]
    rows = np.stack([v, *pattern, *turning])[:, fast]
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
