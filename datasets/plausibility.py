"""Checks of a record's metadata, units and sizes against its samples."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from itertools import combinations, product
from typing import TYPE_CHECKING

import numpy as np

from ..models.errors import BadInput
from .columns import RUDDERS
from .record import Record

if TYPE_CHECKING:
    from ..models.model import Model

ONE_SIDE = 0.9
"""A rudder is held to one side, and a ship turns to one, where this share of the angle, of the yaw rate, is there."""
SIGN_SHARE = 0.3
"""The rudder's sign is questioned where it explains at least this share of what the yaw rate leaves unexplained."""
FEWEST = 20
"""Samples with rudder and yaw rate (windows with two channels) below which sign (units) are not judged."""
DEGREE = np.pi / 180.0
LARGEST_RUDDER, MOVED = 1.6, 0.02
"""Rudder angle, rad, that no rudder reaches, and the range of angles over which a ship turns."""
FAINTEST = 1e-9
"""Range of headings (rad) or yaw rates (rad/s) that no sensor resolves."""
FASTEST, FASTEST_M_S, FASTEST_RAD_S = 10.0, 150.0, 7.0
"""Times the model's speed (yaw rate: its speed over its length) that no record of its ship reaches, and the speed and
yaw rate of anything afloat, for models without a speed or length."""
WINDOW = 10
"""Fewest samples over which changes of two channels are compared."""
NEAR, UNIT_SHARE, ODD = 0.15, 0.02, 5.0
"""How near to their median half of the windows must be, how near that to a unit's factor, and the ratio from which on
it is no error of a sensor whatever the unit."""
TURN_UNITS = {
    "degrees in heading_rad": ("heading_rad", 1.0 / DEGREE),
    "degrees per second in yaw_rate_rad_s": ("yaw_rate_rad_s", DEGREE),
    "milliseconds in time_s": ("time_s", 1e-3),
    "microseconds in time_s": ("time_s", 1e-6),
    "minutes in time_s": ("time_s", 60.0),
}
"""Unit -> the column, and how many times as much the heading then changes as yaw rate and time say."""
WAY_UNITS = {
    "knots in speed columns": ("surge_m_s", 1852.0 / 3600.0),
    "km/h in speed columns": ("surge_m_s", 1.0 / 3.6),
    "milliseconds in time_s": ("time_s", 1e-3),
    "kilometres in position columns": ("north_m", 1e-3),
    "nautical miles in position columns": ("north_m", 1.0 / 1852.0),
    "minutes in time_s": ("time_s", 60.0),
}
"""The same for positions against speeds."""


class RudderSignWarning(UserWarning):
    """The yaw response of a record contradicts the side to which a positive rudder is said to steer."""


def rudder_sign_doubt(record: Record) -> str | None:
    """A sentence if the yaw response contradicts the record's rudder sign, else None.

    Least squares of the integrated first-order response r - r0 = a int r + b int delta + c t, with r to starboard:
    b must have the sign of the rudder.  In a turn, the rudder on one side and the speed falling, b says little:
    there the yaw rate itself, which must stay on one side too, has that sign.
    """
    if record.meta.positive_rudder is None or not (record.has("yaw_rate_rad_s") or record.has("heading_rad")):
        return None
    rate, rudder = _yaw_rate(record), record.rudder()
    known = np.isfinite(rate) & np.isfinite(rudder)
    if known.sum() < FEWEST:
        return None
    time, rate, rudder = record.time_s[known] - record.time_s[known][0], rate[known], rudder[known]
    expected = 1.0 if record.meta.positive_rudder == "starboard" else -1.0
    helm, turn = _one_sided(rudder), _one_sided(rate)
    if abs(helm) > ONE_SIDE:
        contradicts = abs(turn) > ONE_SIDE and helm * turn * expected < 0.0
    else:
        contradicts = _turns_against(time, rate, rudder * expected)
    if not contradicts:
        return None
    return (
        f"rudder_sign: in {record.name} the ship turns against a rudder that is positive to "
        f"{record.meta.positive_rudder}; check positive_rudder"
    )


def _yaw_rate(record: Record) -> np.ndarray:
    if record.has("yaw_rate_rad_s"):
        return record.column("yaw_rate_rad_s")
    return np.gradient(record.heading_unwrapped(), record.time_s)


def _one_sided(values: np.ndarray) -> float:
    """1 where all values (N,) are positive, -1 where all are negative, between where they change sign."""
    size = float(np.sum(np.abs(values)))
    return float(np.sum(values)) / size if size > 0.0 else 0.0


def _turns_against(time: np.ndarray, rate: np.ndarray, rudder: np.ndarray) -> bool:
    """Whether the first-order response has the wrong sign and explains the yaw rate better than none does."""
    columns = np.column_stack([_integral(rudder, time), _integral(rate, time), time, np.ones(time.size)])
    gain, error = _least_squares(columns, rate)
    _, error_without = _least_squares(columns[:, 1:], rate)
    return gain < 0.0 and error <= (1.0 - SIGN_SHARE) * error_without


def _integral(values: np.ndarray, time: np.ndarray) -> np.ndarray:
    """Trapezoidal integral (N,) of values (N,) from the first time."""
    steps = np.diff(time) * (values[1:] + values[:-1]) / 2.0
    return np.concatenate([[0.0], np.cumsum(steps)])


def _least_squares(columns: np.ndarray, values: np.ndarray) -> tuple[float, float]:
    """First coefficient and sum of squared residuals."""
    solution = np.linalg.lstsq(columns, values, rcond=None)[0]
    return float(solution[0]), float(np.sum((values - columns @ solution) ** 2))


# ------------------------------------------------------------------------------------------------ sizes and units


def check_plausible(records: Sequence[Record], model: Model) -> None:
    """Refuse records that hold the same run twice, or whose numbers are in another unit than their columns say.

    Raises
    ------
    BadInput : naming record, row and column where there are any, and the unit that the numbers are likely in.
    """
    check_no_copies(records)
    for record in records:
        _check_rudder(record)
        _check_speed(record, model)
        _check_rate(record, model)
        _check_alive(record)
        _check_turned(record)
        _check_way(record)


def check_no_copies(records: Sequence[Record], others: Sequence[Record] | None = None) -> None:
    """Refuse records that hold the samples of another one: such a run would count twice.

    others : held-out records, which are compared with the records; None: the records are compared with each other.

    Raises
    ------
    BadInput : naming both records.
    """
    pairs = combinations(records, 2) if others is None else product(records, others)
    for first, second in pairs:
        if same_samples(first, second):
            repeated = f"holds the same samples as {first.name}"
            said = repeated if others is None else "is both a training record and held out"
            hint = "give every run once; a held-out record takes no part in training"
            raise BadInput(said, file=second.name, hint=hint)


def same_samples(first: Record, second: Record) -> bool:
    """Whether two records have equal times and channels, whatever they are called."""
    return (
        first.n == second.n
        and first.channels.keys() == second.channels.keys()
        and np.array_equal(first.time_s, second.time_s)
        and all(np.array_equal(first.channels[k], second.channels[k], equal_nan=True) for k in first.channels)
    )


def _check_rudder(record: Record) -> None:
    for name in RUDDERS:
        if not record.has(name):
            continue
        angle = np.nan_to_num(np.abs(record.column(name)))
        largest = float(angle.max())
        if largest > LARGEST_RUDDER:
            degrees = largest * DEGREE <= LARGEST_RUDDER
            hint = f"degrees? then call the column {name.replace('_rad', '_deg')}" if degrees else "check the column"
            when = record.time_s[int(angle.argmax())]
            message = f"a rudder angle of {largest:.4g} rad at {when:.6g} s, beyond {LARGEST_RUDDER} rad"
            raise BadInput(message, file=record.name, column=name, hint=hint)


def _check_speed(record: Record, model: Model) -> None:
    known = np.isfinite(model.speed_m_s)
    most = FASTEST * model.speed_m_s if known else FASTEST_M_S
    for name in ("surge_m_s", "sway_m_s"):
        speed = _usual_size(record, name)
        if speed > most:
            said = f"{FASTEST:.0f} times the {model.speed_m_s:.4g} m/s of {model.id}" if known else f"{most:.0f} m/s"
            hint = "check its unit, its scale (model or full scale) and that the model is that of the ship"
            raise BadInput(f"a speed of {speed:.4g} m/s, above {said}", file=record.name, column=name, hint=hint)


def _check_alive(record: Record) -> None:
    """Refuse a heading or a yaw rate that stays the same while the rudder moves."""
    rudder = record.rudder() if record.has(RUDDERS[0]) or record.has(RUDDERS[1]) else np.zeros(1)
    rudder = rudder[np.isfinite(rudder)]
    if not rudder.size or np.ptp(rudder) < MOVED:
        return
    for name in ("heading_rad", "yaw_rate_rad_s"):
        values = record.column(name) if record.has(name) else np.zeros(0)
        values = values[np.isfinite(values)]
        if values.size > 1 and np.ptp(values) < FAINTEST:
            message = f"stays at {values[0]:.4g} while the rudder moves by {np.ptp(rudder):.3g} rad"
            raise BadInput(message, file=record.name, column=name, hint="a dead sensor? leave the column out")


def _check_rate(record: Record, model: Model) -> None:
    length, speed = model.particulars.get("L"), model.speed_m_s
    most = FASTEST * speed / length if length is not None and np.isfinite(speed) else FASTEST_RAD_S
    rate = _usual_size(record, "yaw_rate_rad_s")
    if rate > most:
        degrees = rate * DEGREE <= most
        hint = "degrees per second? then call the column yaw_rate_deg_s" if degrees else "check its unit and its scale"
        message = f"a yaw rate of {rate:.4g} rad/s, beyond {most:.3g} rad/s"
        raise BadInput(message, file=record.name, column="yaw_rate_rad_s", hint=hint)


def _check_turned(record: Record) -> None:
    """Compare the heading's changes with the yaw rate's integral."""
    if record.has("heading_rad", "yaw_rate_rad_s"):
        turned = _changes(record, record.column("heading_rad"))
        integral = _changes(record, _integral_over_gaps(record.column("yaw_rate_rad_s"), record.time_s))
        _check_ratio(record, _ratio(turned, integral), TURN_UNITS, "headings", "heading, yaw rate and time")


def _check_way(record: Record) -> None:
    """Compare the way made by the positions with that by the speeds."""
    if record.has("surge_m_s", "sway_m_s", "north_m", "east_m"):
        with np.errstate(all="ignore"):
            way = np.hypot(_changes(record, record.column("north_m")), _changes(record, record.column("east_m")))
            speed = np.hypot(record.column("surge_m_s"), record.column("sway_m_s"))
        sailed = _changes(record, _integral_over_gaps(speed, record.time_s))
        _check_ratio(record, _ratio(way, sailed), WAY_UNITS, "positions", "positions, speeds and time")


def _check_ratio(
    record: Record, ratio: float | None, units: Mapping[str, tuple[str, float]], what: str, columns: str
) -> None:
    """Refuse a ratio of changes that only another unit can make."""
    if ratio is None:
        return
    message = f"{what} change {ratio:.4g} times as much as the rates of change and the time say"
    for unit, (column, factor) in units.items():
        if abs(ratio / factor - 1.0) < UNIT_SHARE:
            raise BadInput(message, file=record.name, column=column, hint=f"{unit}? name the column so, or convert it")
    if not 1.0 / ODD < ratio < ODD:
        raise BadInput(message, file=record.name, hint=f"check the units of {columns}")


def _usual_size(record: Record, name: str) -> float:
    """Size below which 99 of 100 samples of a channel are (single gross errors do not count); 0 without samples."""
    values = np.abs(record.column(name)) if record.has(name) else np.zeros(0)
    values = values[np.isfinite(values)]
    return float(np.quantile(values, 0.99)) if values.size else 0.0


def _integral_over_gaps(values: np.ndarray, time: np.ndarray) -> np.ndarray:
    """Trapezoidal integral (N,) that is nan where values are missing and goes on after them."""
    with np.errstate(all="ignore"):
        steps = np.nan_to_num(np.diff(time) * (values[1:] + values[:-1]) / 2.0)
        return np.where(np.isfinite(values), np.concatenate([[0.0], np.cumsum(steps)]), np.nan)


def _changes(record: Record, values: np.ndarray) -> np.ndarray:
    """Changes (M,) of a series over windows of WINDOW samples or more, nan where a sample between is missing."""
    window = max(1, min(max(WINDOW, record.n // 40), record.n // 10))
    gaps = np.concatenate([[0], np.cumsum(~np.isfinite(values) | _after_gap(record))])
    with np.errstate(all="ignore"):
        change = values[window:] - values[:-window]
    return np.where(gaps[window + 1 :] == gaps[1 : record.n + 1 - window], change, np.nan)


def _after_gap(record: Record) -> np.ndarray:
    """(N,) whether rows are missing before a sample."""
    return np.concatenate([[False], np.diff(record.time_s) > 1.5 * record.dt])


def _ratio(first: np.ndarray, second: np.ndarray) -> float | None:
    """Median ratio of two series of changes (M,) in the windows with the larger changes; None where half of the
    windows do not agree on it."""
    known = np.isfinite(first) & np.isfinite(second) & (second != 0.0)
    if known.sum() < FEWEST:
        return None
    first, second = first[known], second[known]
    large = np.abs(second) >= np.median(np.abs(second))
    with np.errstate(all="ignore"):
        ratio = first[large] / second[large]
        median = float(np.median(ratio))
        agreed = np.mean(np.abs(ratio / median - 1.0) < NEAR)
    return median if median > 0.0 and agreed > 0.5 else None
