"""The rudder's sign against the yaw response."""

from __future__ import annotations

import numpy as np

from .geometry import unwrapped
from .plausibility import PlausibilityWarning
from .record import Record, Side
from .yaw_response import FEWEST, yaw_response

ONE_SIDE = 0.9
"""A rudder is held to one side, and a ship turns to one, where this share of the angle, of the yaw rate, is there."""
SIGN_SHARE = 0.5
"""Least share of the yaw rate that the response to the rudder explains where it tells the rudder's side."""


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

    The share of the yaw rate that its response to the rudder explains (`yaw_response`) is the certainty.  In a turn,
    the rudder on one side and the speed falling, the response says little: there the yaw rate itself, which must stay
    on one side too, has the sign.
    """
    rate, rudder = _yaw_rate(record), record.rudder()
    if rate is None or np.sum(known := np.isfinite(rate) & np.isfinite(rudder)) < FEWEST:
        return None
    helm, turn = one_sided(rudder[known]), one_sided(rate[known])
    if abs(helm) > ONE_SIDE:
        return (_side(helm * turn), abs(turn)) if abs(turn) > ONE_SIDE else None
    response = yaw_response(record.time_s, rate, rudder)
    return (_side(response.gain), response.share) if response is not None and response.is_sure(SIGN_SHARE) else None


def _side(value: float) -> Side:
    return "starboard" if value > 0.0 else "port"


def _yaw_rate(record: Record) -> np.ndarray | None:
    """The yaw rate (N,), rad/s, by its sensor, by the heading or by the course of the track; None without any."""
    if record.has("yaw_rate_rad_s"):
        return record.column("yaw_rate_rad_s")
    if record.has("heading_rad"):
        return np.gradient(record.heading_unwrapped(), record.time_s)
    if record.has("north_m", "east_m"):
        north, east = (np.gradient(record.column(name), record.time_s) for name in ("north_m", "east_m"))
        return np.gradient(unwrapped(np.arctan2(east, north)), record.time_s)
    return None


def one_sided(values: np.ndarray) -> float:
    """1 where all values (N,) are positive, -1 where all are negative, between where they change sign."""
    size = float(np.sum(np.abs(values)))
    return float(np.sum(values)) / size if size > 0.0 else 0.0
