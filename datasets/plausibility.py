"""Checks of a record's metadata against its samples."""

from __future__ import annotations

import numpy as np

from .record import Record

SIGN_SHARE = 0.3
"""The rudder's sign is questioned where it explains at least this share of what the yaw rate leaves unexplained."""
FEWEST = 20
"""Samples with rudder and yaw rate below which the sign is not judged."""


class RudderSignWarning(UserWarning):
    """The yaw response of a record contradicts the side to which a positive rudder is said to steer."""


def rudder_sign_doubt(record: Record) -> str | None:
    """A sentence if the yaw response contradicts the record's rudder sign, else None.

    Least squares of the integrated first-order response r - r0 = a int r + b int delta + c t, with r to starboard:
    b must have the sign of the rudder.
    """
    if record.meta.positive_rudder is None or not (record.has("yaw_rate_rad_s") or record.has("heading_rad")):
        return None
    rate, rudder = _yaw_rate(record), record.rudder()
    known = np.isfinite(rate) & np.isfinite(rudder)
    if known.sum() < FEWEST:
        return None
    time, rate, rudder = record.time_s[known] - record.time_s[known][0], rate[known], rudder[known]
    columns = np.column_stack([_integral(rudder, time), _integral(rate, time), time, np.ones(time.size)])
    gain, error = _least_squares(columns, rate)
    _, error_without = _least_squares(columns[:, 1:], rate)
    expected = 1.0 if record.meta.positive_rudder == "starboard" else -1.0
    if gain * expected >= 0.0 or error > (1.0 - SIGN_SHARE) * error_without:
        return None
    return (
        f"rudder_sign: in {record.name} the ship turns against a rudder that is positive to "
        f"{record.meta.positive_rudder}; check positive_rudder"
    )


def _yaw_rate(record: Record) -> np.ndarray:
    if record.has("yaw_rate_rad_s"):
        return record.column("yaw_rate_rad_s")
    return np.gradient(record.heading_unwrapped(), record.time_s)


def _integral(values: np.ndarray, time: np.ndarray) -> np.ndarray:
    """Trapezoidal integral (N,) of values (N,) from the first time."""
    steps = np.diff(time) * (values[1:] + values[:-1]) / 2.0
    return np.concatenate([[0.0], np.cumsum(steps)])


def _least_squares(columns: np.ndarray, values: np.ndarray) -> tuple[float, float]:
    """First coefficient and sum of squared residuals."""
    solution = np.linalg.lstsq(columns, values, rcond=None)[0]
    return float(solution[0]), float(np.sum((values - columns @ solution) ** 2))
