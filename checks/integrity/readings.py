"""Readings of a record's columns: how well heading, rates, velocities and positions agree, as they are or exchanged."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from ...datasets.geometry import body_velocities
from ...datasets.signals import integral

if TYPE_CHECKING:
    from ...datasets.record import Record

WINDOW_S = 8.0
BETTER = 0.5
"""Share of the present disagreement below which another reading of the columns is believed."""
FEWEST = 20
"""Samples with all channels below which nothing is compared."""
LEAST = 0.02
"""Disagreement, as a share of the way made, from which another reading is looked for."""
TRACK = ("heading_rad", "surge_m_s", "sway_m_s", "north_m", "east_m")
Reread = Callable[["Record"], "Record"]


def exchanged(first: str, second: str) -> Reread:
    """A record with two columns exchanged."""

    def reading(record: Record) -> Record:
        return record.with_channels(**{first: record.column(second), second: record.column(first)})

    return reading


def to_body(record: Record) -> Record:
    """Velocities along north and east turned into body axes."""
    psi, north, east = record.heading_unwrapped(), record.column("surge_m_s"), record.column("sway_m_s")
    surge, sway = body_velocities(north, east, psi)
    return record.with_channels(surge_m_s=surge, sway_m_s=sway)


class Reading(NamedTuple):
    """Another reading of velocities and positions: the columns that are exchanged (none: velocities in the earth
    frame), and the record read so."""

    columns: tuple[str, ...]
    read: Reread


class Better(NamedTuple):
    """A reading that agrees far better, with the present and its own disagreement (shares of the way made)."""

    reading: Reading
    present: float
    own: float


PAIRS = (("surge_m_s", "sway_m_s"), ("north_m", "east_m"))
READINGS = (Reading((), to_body), *(Reading(pair, exchanged(*pair)) for pair in PAIRS))


def better_reading(records: Sequence[Record]) -> Better | None:
    """The reading of velocities and positions that agrees far better than the present one; None without any."""
    usable = [r for r in records if r.has(*TRACK)]
    if not usable:
        return None
    present = float(np.mean([track_error(r) for r in usable]))
    errors = [float(np.mean([track_error(reading.read(r)) for r in usable])) for reading in READINGS]
    best = int(np.argmin(errors))
    return Better(READINGS[best], present, errors[best]) if errors[best] < BETTER * present > BETTER * LEAST else None


def read_as(records: Sequence[Record], reading: Reading) -> list[Record]:
    """The records with another reading of the track's columns, where they have them."""
    return [reading.read(r) if r.has(*TRACK) else r for r in records]


def rate_error(record: Record, name: str) -> float:
    """Share of the heading's changes over windows that a rate column does not give; nan for too few samples."""
    psi, rate, time = record.heading_unwrapped(), record.column(name), record.time_s
    known = np.isfinite(psi) & np.isfinite(rate)
    if known.sum() < FEWEST:
        return float("nan")
    psi, rate, time = psi[known], rate[known], time[known]
    step = min(max(2, round(WINDOW_S / 8.0 / np.median(np.diff(time)))), time.size // 2)
    turned = psi[step:] - psi[:-step]
    given = integral(rate, time)
    error = turned - (given[step:] - given[:-step])
    return float(np.sqrt(np.mean(error**2) / max(np.mean(turned**2), 1e-300)))


def track_error(record: Record) -> float:
    """Error of the displacement over windows that heading and velocities give, as a share of the way made; nan for too
    few samples."""
    psi, u, v = record.heading_unwrapped(), record.column("surge_m_s"), record.column("sway_m_s")
    x, y, time = record.column("north_m"), record.column("east_m"), record.time_s
    known = np.all(np.isfinite([psi, u, v, x, y]), axis=0)
    if known.sum() < FEWEST:
        return float("nan")
    psi, u, v, x, y, time = (a[known] for a in (psi, u, v, x, y, time))
    step = int(np.clip(round(WINDOW_S / np.median(np.diff(time))), 2, time.size // 2))
    north, east = u * np.cos(psi) - v * np.sin(psi), u * np.sin(psi) + v * np.cos(psi)
    errors, way = [], []
    for place, rate in ((x, north), (y, east)):
        given = integral(rate, time)
        moved = place[step:] - place[:-step]
        errors.append(moved - (given[step:] - given[:-step]))
        way.append(moved)
    return float(np.sqrt(np.mean(np.square(errors)) / max(np.mean(np.square(way)), 1e-300)))
