"""How the yaw rate answers what steers, and the rudder's sign that it tells."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from .geometry import unwrapped
from .plausibility import PlausibilityWarning
from .record import Record, Side
from .signals import integral

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


# ---- How the yaw rate answers what steers: a first-order response of its own, without the measured yaw rate in it.
# r(t) = K h(t) + c + d exp(-t/T), T dh/dt + h = helm(t - lag): Nomoto's equation (Nomoto et al. 1957, Int. Shipb.
# Progr. 4), with the gain K free and T, lag > 0 searched.  An autopilot answers the yaw rate as well, but later: a helm
# that follows the yaw rate is a good likeness of it at the same time, and no better a cause of it later.  So a response
# counts by what it explains beyond the helm at the same time.

MEANS, FEWEST = 400, 20
"""Means over equal stretches that are compared, and samples below which nothing is."""
CONSTANTS, QUICKEST, SLOWEST = 14, 0.5, 0.25
"""Time constants that are tried; the least of them in stretches, the largest as a share of the record."""
LAGS, LATEST = (0, 1, 2, 3, 5), 0.02
"""Lags that are tried, in stretches, and the largest as a share of the record."""
KEPT = 0.8
"""Least share of the variance of yaw rate or helm that means over stretches keep."""
STILL = 1e-9
"""Share of the square of a response that is left without its mean and its start, below which it stands still."""
LEADS, RIVAL = 0.2, 0.5
"""Least share that a response explains beyond the helm at the same time, and most that the other sign may of it."""


class YawResponse(NamedTuple):
    """The response that explains most of a yaw rate.

    share : of the yaw rate's square about its mean that it explains.  gain : its sign, 1 or -1.  opposite : the share
    that the best response of the other sign explains.  beyond : of what the helm at the same time leaves, the share
    that the response explains.  rate, answer : yaw rate and response (M,), about their means.
    """

    share: float
    gain: float
    opposite: float
    beyond: float
    rate: np.ndarray
    answer: np.ndarray

    def is_sure(self, least: float) -> bool:
        """Whether it explains a least share, later than the helm, and is no mirror image."""
        return self.share >= least and self.beyond >= LEADS and self.opposite <= RIVAL * self.share


def yaw_response(
    time: np.ndarray, rate: np.ndarray, helm: np.ndarray, lags: tuple[int, ...] = LAGS
) -> YawResponse | None:
    """The response of a yaw rate (N,) to a helm (N,) at rising times (N,), s; None where either never changes.

    lags : in stretches of the record, besides the largest one.
    """
    known = np.isfinite(rate) & np.isfinite(helm)
    if known.sum() < FEWEST or not all(np.ptp(values[known]) > 0.0 for values in (rate, helm)):
        return None
    turning, steering = _resolved(time[known], _scaled(rate[known]), _scaled(helm[known]))
    n = turning.size
    late = sorted({*lags, round(LATEST * n)} if len(lags) > 1 else lags)
    constants = np.concatenate([[0.0], np.geomspace(QUICKEST, max(SLOWEST * n, 1.0), CONSTANTS)])
    kept = np.exp(-1.0 / np.maximum(constants, 1e-3))
    moved = steering - steering[0]
    follows, state = np.empty((n, kept.size)), np.zeros(kept.size)  # from rest, with the share that each keeps
    for i, wanted in enumerate(moved):
        follows[i] = state = wanted + kept * (state - wanted)
    tried = [entry for k, own in zip(kept, follows.T, strict=True) for entry in _answers(turning, own, k, late)]
    if not tried:
        return None
    share, gain, answer = max(tried, key=lambda entry: entry[0])
    opposite = max((other for other, sign, _ in tried if sign != gain), default=0.0)
    same = tried[0][0] if tried[0][1] == gain else 0.0
    beyond = (share - same) / max(1.0 - same, 1e-12)
    return YawResponse(share, gain, opposite, beyond, turning - turning.mean(), answer)


def _scaled(values: np.ndarray) -> np.ndarray:
    """Values (N,) over the largest of them: a sample of 1e300 has no square."""
    return values / max(float(np.max(np.abs(values))), 1e-300)


def _resolved(time: np.ndarray, rate: np.ndarray, helm: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Means (M,) of yaw rate and helm (N,) over the record, or over the quarter with most turning, again and again as
    long as the means lose most of both: a day's log holds manoeuvres of minutes."""
    while True:
        means = _means(time, rate), _means(time, helm)
        lost = all(np.var(m) < KEPT * np.var(x) for m, x in zip(means, (rate, helm), strict=True))
        if not lost or rate.size < 4 * MEANS:
            return means
        ends = np.searchsorted(time, np.linspace(time[0], time[-1], 5)[1:-1])
        parts = [(*part,) for part in zip(*(np.split(x, ends) for x in (time, rate, helm)), strict=True)]
        time, rate, helm = max(
            parts, key=lambda part: part[0].size * np.var(part[1]) if part[0].size >= FEWEST else -1.0
        )


def _means(time: np.ndarray, values: np.ndarray) -> np.ndarray:
    """Means (M,) of values (N,) over equal stretches of the time."""
    count = min(MEANS, max(values.size // 2, FEWEST))
    edges = np.linspace(time[0], time[-1], count + 1)
    return np.diff(np.interp(edges, time, integral(values, time))) / (edges[1] - edges[0])


def _answers(
    turning: np.ndarray, follows: np.ndarray, kept: float, lags: list[int]
) -> list[tuple[float, float, np.ndarray]]:
    """(share, sign of the gain, response (M,)) of what follows the helm, at each lag; none that stands still."""
    n = turning.size
    base, _ = np.linalg.qr(np.column_stack([np.ones(n), kept ** np.arange(n)]))
    late = np.stack([np.concatenate([np.zeros(lag), follows[: n - lag]]) for lag in lags])
    moves, wanted = late - (late @ base) @ base.T, turning - base @ (base.T @ turning)
    powers, power, products = np.sum(moves**2, axis=1), float(wanted @ wanted), moves @ wanted
    live = (powers > STILL * np.sum(late**2, axis=1)) & (power > 0.0)
    found = zip(powers[live], products[live], moves[live], strict=True)
    return [(float(c * c / (p * power)), 1.0 if c > 0.0 else -1.0, m * float(c / p)) for p, c, m in found]
