"""Changes of records whose answer is known: what wrong data do, and what must never become a hull.

Each takes records of one ship and returns what a logger, an export or a hand could have made of them.
"""

from collections.abc import Callable
from dataclasses import replace

import numpy as np

from helmbench.datasets.record import Record

DEGREE = np.pi / 180.0
ANGLES = ("rudder_rad", "rudder_command_rad", "heading_rad", "yaw_rate_rad_s")
RUDDERS = ANGLES[:2]
Change = Callable[[Record, np.random.Generator], Record]


def scaled(names, factor) -> Change:
    return lambda r, rng: r.with_channels(**{n: factor * r.column(n) for n in names if r.has(n)})


def kept(r: Record, rows: np.ndarray) -> Record:
    return replace(r, time_s=r.time_s[rows], channels={n: v[rows] for n, v in r.channels.items()})


def shifted(names, seconds) -> Change:
    """Channels recorded late by so many seconds."""

    def change(r, rng):
        own = [n for n in names if r.has(n)]
        return r.with_channels(**{n: np.interp(r.time_s - seconds * _span(r), r.time_s, r.column(n)) for n in own})

    return change


def _span(r: Record) -> float:
    """Seconds of a record in hundredths of its duration: a delay that is long for this ship."""
    return float(np.ptp(r.time_s)) / 100.0


def shuffled(r, rng):
    order = rng.permutation(r.n)
    return r.with_channels(**{n: r.column(n)[order] for n in RUDDERS if r.has(n)})


def heading_added(angle) -> Change:
    return lambda r, rng: r.with_channels(heading_rad=r.heading_unwrapped() + angle)


def rows_lost(r, rng):
    rows = np.sort(rng.choice(r.n, int(0.7 * r.n), replace=False))
    return kept(r, rows)


def gap(r, rng):
    t = (r.time_s - r.time_s[0]) / np.ptp(r.time_s)
    return kept(r, np.flatnonzero((t < 0.35) | (t > 0.65)))


def dropouts(r, rng):
    """Tenths of the samples of each sensor missing."""
    names = [n for n in r.channels if n not in RUDDERS]
    return r.with_channels(**{n: np.where(rng.random(r.n) < 0.1, np.nan, r.column(n)) for n in names})


def exchanged(a, b) -> Change:
    return lambda r, rng: r.with_channels(**{a: r.column(b), b: r.column(a)}) if r.has(a, b) else r


def constant(name) -> Change:
    return lambda r, rng: r.with_channels(**{name: np.full(r.n, np.nanmean(r.column(name)))}) if r.has(name) else r


def reversed_time(r, rng):
    return r.with_channels(**{n: v[::-1].copy() for n, v in r.channels.items()})


def earth_frame(r, rng):
    if not r.has("surge_m_s", "sway_m_s"):
        return r
    psi, u, v = r.heading_unwrapped(), r.column("surge_m_s"), r.column("sway_m_s")
    return r.with_channels(surge_m_s=u * np.cos(psi) - v * np.sin(psi), sway_m_s=u * np.sin(psi) + v * np.cos(psi))


def outliers(r, rng):
    channels = {}
    for n in (n for n in ("heading_rad", "yaw_rate_rad_s", "surge_m_s") if r.has(n)):
        values, at = r.column(n).copy(), rng.choice(r.n, max(r.n // 100, 5), replace=False)
        values[at] += rng.choice([-1.0, 1.0], at.size) * 20.0 * np.nanstd(values)
        channels[n] = values
    return r.with_channels(**channels)


def halves_exchanged(r, rng):
    middle = r.n // 2
    return r.with_channels(**{n: np.concatenate([v[middle:], v[:middle]]) for n, v in r.channels.items()})


def straight(r, rng):
    """The rudder amidships all the time, the motion as it was."""
    return r.with_channels(**{n: np.zeros(r.n) for n in RUDDERS if r.has(n)})


def time_doubled(r, rng):
    """Rows of a logger that is said to be half as fast as it is."""
    return replace(r, time_s=r.time_s[0] + 2.0 * (r.time_s - r.time_s[0]))


CHANGES: dict[str, Change] = {
    "radians in the rudder's degrees": scaled(RUDDERS, DEGREE),
    "radians in all degrees": scaled(ANGLES, DEGREE),
    "degrees in heading": scaled(("heading_rad",), 1.0 / DEGREE),
    "degrees in yaw rate": scaled(("yaw_rate_rad_s",), 1.0 / DEGREE),
    "rudder doubled": scaled(RUDDERS, 2.0),
    "rudder late": shifted(RUDDERS, 5.0),
    "rudder early": shifted(RUDDERS, -5.0),
    "rudder shuffled": shuffled,
    "rudder turned": scaled(RUDDERS, -1.0),
    "rudder amidships": straight,
    "heading turned": scaled(("heading_rad",), -1.0),
    "yaw rate turned": scaled(("yaw_rate_rad_s",), -1.0),
    "heading + 180": heading_added(np.pi),
    "heading + 90": heading_added(0.5 * np.pi),
    "rows lost": rows_lost,
    "gap": gap,
    "dropouts": dropouts,
    "constant speed": constant("surge_m_s"),
    "knots": scaled(("surge_m_s", "sway_m_s"), 3600.0 / 1852.0),
    "velocities exchanged": exchanged("surge_m_s", "sway_m_s"),
    "positions exchanged": exchanged("north_m", "east_m"),
    "earth frame": earth_frame,
    "time reversed": reversed_time,
    "outliers": outliers,
    "halves exchanged": halves_exchanged,
    "sway turned": scaled(("sway_m_s",), -1.0),
    "time doubled": time_doubled,
    "positions in feet": scaled(("north_m", "east_m"), 1.0 / 0.3048),
    "heading and yaw rate exchanged": exchanged("heading_rad", "yaw_rate_rad_s"),
}
