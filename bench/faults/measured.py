"""Effects planted in measured records: what the sensors or the rudder channel could have got wrong.

`spoil` takes any record, changes its columns only, and leaves gaps where a shifted channel has none to give.
Definitions and units are those of the taxonomy: the rudder at the hull is (1 + e) recorded(t - tau) + delta0, so a
planted offset takes delta0 out of the recorded column, and a planted delay moves the column forward in time.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from ...datasets.columns import RUDDERS
from ...datasets.record import Record
from ...models.errors import BadInput
from .sensing import ATTITUDE, VELOCITY

Rows = dict[str, np.ndarray]


def spoil(record: Record, cause: str, parameters: dict[str, Any], rng: np.random.Generator) -> Record:
    """The record as it would read under a cause of `SPOILERS`; BadInput for another one or a missing channel."""
    if cause not in SPOILERS:
        raise BadInput(f"{cause} cannot be planted in a measured record", hint=f"{', '.join(SPOILERS)} can")
    columns = {name: record.column(name).copy() for name in record.channels}
    if "heading_rad" in columns:
        columns["heading_rad"] = record.heading_unwrapped().copy()
    try:
        SPOILERS[cause](columns, record.time_s, parameters, rng)
    except KeyError as error:
        raise BadInput(f"{cause} needs the column {error}", file=record.name) from None
    return record.with_channels(**columns)


def _rudders(rows: Rows) -> list[str]:
    return [name for name in RUDDERS if name in rows]


def _shift(rows: Rows, time: np.ndarray, names, tau: float) -> None:
    """recorded(t) = true(t - tau); nan outside the record."""
    for name in names:
        known = np.isfinite(rows[name])
        moved = np.interp(time - tau, time[known], rows[name][known], left=np.nan, right=np.nan)
        late = np.interp(time - tau, time, known.astype(float), left=0.0, right=0.0)
        rows[name] = np.where(late > 0.999, moved, np.nan)


def _rudder(change: Callable[[np.ndarray, dict], np.ndarray]):
    def apply(rows: Rows, time, p, rng) -> None:
        for name in _rudders(rows):
            rows[name] = change(rows[name], p)

    return apply


def _rudder_delay(rows: Rows, time, p, rng) -> None:
    """The ends, for which there is no later rudder, keep the last value: a rudder column has no gaps."""
    for name in _rudders(rows):
        rows[name] = np.interp(time + p["tau"], time, rows[name])


def _linear(*names: str):
    def apply(rows: Rows, time, p, rng) -> None:
        for name in names:
            rows[name] = (1.0 + p.get("s", 0.0)) * rows[name] + p.get("b", 0.0)

    return apply


def _heading_delay(rows: Rows, time, p, rng) -> None:
    _shift(rows, time, ["heading_rad"], p["tau"])


def _velocity_delay(rows: Rows, time, p, rng) -> None:
    names = [*VELOCITY, *(ATTITUDE if p.get("attitude") else ())]
    _shift(rows, time, [name for name in names if name in rows], p["tau"])


def _turn(rows: Rows, angle) -> None:
    surge, sway = (rows[name] for name in VELOCITY)
    rows[VELOCITY[0]] = np.cos(angle) * surge + np.sin(angle) * sway
    rows[VELOCITY[1]] = -np.sin(angle) * surge + np.cos(angle) * sway


def _misaligned(rows: Rows, time, p, rng) -> None:
    _turn(rows, p["angle"])


def _earth_frame(rows: Rows, time, p, rng) -> None:
    _turn(rows, -rows["heading_rad"])


def _swap(rows: Rows, time, p, rng) -> None:
    first, second = p["channels"]
    rows[first], rows[second] = rows[second], rows[first]


def _outliers(rows: Rows, time, p, rng) -> None:
    """12 to 30 times the channel's own noise, taken from its third differences."""
    for name in [name for name in rows if name not in RUDDERS]:
        steps = np.diff(rows[name], 3)
        sd = 1.4826 * np.nanmedian(np.abs(steps)) / np.sqrt(20.0)
        n = time.size
        error = rng.choice([-1.0, 1.0], n) * rng.uniform(12.0, 30.0, n) * sd
        rows[name] = rows[name] + np.where(rng.random(n) < p["share"], error, 0.0)


def _jitter(rows: Rows, time, p, rng) -> None:
    taken = np.clip(time + p["sd"] * rng.standard_normal(time.size), time[0], time[-1])
    for name, values in rows.items():
        rows[name] = np.interp(taken, time, values)


SPOILERS: dict[str, Callable[[Rows, np.ndarray, dict, np.random.Generator], None]] = {
    "rudder_offset": _rudder(lambda rudder, p: rudder - p["delta0"]),
    "rudder_effectiveness": _rudder(lambda rudder, p: rudder / (1.0 + p["e"])),
    "rudder_sign": _rudder(lambda rudder, p: -rudder),
    "rudder_delay": _rudder_delay,
    "yaw_rate_bias": _linear("yaw_rate_rad_s"),
    "yaw_rate_scale": _linear("yaw_rate_rad_s"),
    "heading_offset": _linear("heading_rad"),
    "speed_scale": _linear(*VELOCITY),
    "sway_offset": _linear("sway_m_s"),
    "heading_delay": _heading_delay,
    "velocity_delay": _velocity_delay,
    "axis_misalignment": _misaligned,
    "earth_frame_velocity": _earth_frame,
    "channel_swap": _swap,
    "outliers": _outliers,
    "clock_jitter": _jitter,
}
