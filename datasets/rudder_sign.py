"""The rudder's sign against the yaw response."""

from __future__ import annotations

import numpy as np

from ..models.linear_algebra import lstsq
from .plausibility import PlausibilityWarning
from .record import Record, Side
from .signals import integral

ONE_SIDE = 0.9
"""A rudder is held to one side, and a ship turns to one, where this share of the angle, of the yaw rate, is there."""
SIGN_SHARE = 0.3
"""The rudder's sign is questioned where it explains at least this share of what the yaw rate leaves unexplained."""
FEWEST = 20
"""Samples with rudder and yaw rate below which the sign is not judged."""


class RudderSignWarning(PlausibilityWarning):
    """The yaw response of a record contradicts the side to which a positive rudder is said to steer."""


def rudder_sign_doubt(record: Record) -> str | None:
    """A sentence if the yaw response contradicts the record's rudder sign, else None."""
    if record.meta.positive_rudder is None:
        return None
    told = steering_side(record)
    if told is None or told[0] == record.meta.positive_rudder:
        return None
    return (
        f"rudder_sign: in {record.name} the ship turns against a rudder that is positive to "
        f"{record.meta.positive_rudder}; check positive_rudder"
    )


def steering_side(record: Record) -> tuple[Side, float] | None:
    """The side to which a positive rudder turns the ship, and how surely from 0 to 1; None where nothing tells it.

    Least squares of the integrated first-order response r - r0 = a int r + b int delta + c t, with r to starboard:
    b has the sign of the rudder; the share of what the yaw rate leaves unexplained without b is its certainty.  In a
    turn, the rudder on one side and the speed falling, b says little: there the yaw rate itself, which must stay on
    one side too, has that sign.
    """
    if not (record.has("yaw_rate_rad_s") or record.has("heading_rad")):
        return None
    rate, rudder = _yaw_rate(record), record.rudder()
    known = np.isfinite(rate) & np.isfinite(rudder)
    if known.sum() < FEWEST:
        return None
    time, rate, rudder = record.time_s[known] - record.time_s[known][0], _scaled(rate[known]), _scaled(rudder[known])
    helm, turn = one_sided(rudder), one_sided(rate)
    if abs(helm) > ONE_SIDE:
        return (_side(helm * turn), abs(turn)) if abs(turn) > ONE_SIDE else None
    gain, share = _response(time, rate, rudder)
    return (_side(gain), share) if share >= SIGN_SHARE and gain != 0.0 else None


def _scaled(values: np.ndarray) -> np.ndarray:
    """Values (N,) over the largest of them: a sample of 1e300 has no square."""
    return values / max(float(np.max(np.abs(values))), 1e-300)


def _side(value: float) -> Side:
    return "starboard" if value > 0.0 else "port"


def _yaw_rate(record: Record) -> np.ndarray:
    if record.has("yaw_rate_rad_s"):
        return record.column("yaw_rate_rad_s")
    return np.gradient(record.heading_unwrapped(), record.time_s)


def one_sided(values: np.ndarray) -> float:
    """1 where all values (N,) are positive, -1 where all are negative, between where they change sign."""
    size = float(np.sum(np.abs(values)))
    return float(np.sum(values)) / size if size > 0.0 else 0.0


def _response(time: np.ndarray, rate: np.ndarray, rudder: np.ndarray) -> tuple[float, float]:
    """Gain of the first-order response to the rudder, and the share of the squared error that the rudder takes off."""
    columns = np.column_stack([integral(rudder, time), integral(rate, time), time, np.ones(time.size)])
    gain, error = _least_squares(columns, rate)
    _, error_without = _least_squares(columns[:, 1:], rate)
    return gain, 1.0 - error / error_without if error_without > 0.0 else 0.0


def _least_squares(columns: np.ndarray, values: np.ndarray) -> tuple[float, float]:
    """First coefficient and sum of squared residuals."""
    solution = lstsq(columns, values)
    return float(solution[0]), float(np.sum((values - columns @ solution) ** 2))
