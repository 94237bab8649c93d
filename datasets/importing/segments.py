"""Manoeuvres in a long record, found from the rudder: zigzags, turns, straight runs."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import pairwise
from typing import TypeAlias

import numpy as np

from ..columns import RUDDERS
from ..indices import performed
from ..io import MIN_SAMPLES
from ..record import Record
from ..signals import integral_over_gaps

LEAST_RAD, SHARE = math.radians(2.0), 0.15
"""Rudder angle above which the rudder is laid: this, or that share of the largest angle."""
CROSSINGS, FEWEST = 8.0, 10
"""A rudder amidships for longer than that many times its way through amidships, and samples, is a straight run."""
LEAD_S = 10.0
"""Seconds of straight run that are kept before a manoeuvre."""


@dataclass(frozen=True)
class ManoeuvreSegment:
    """Samples start:stop; kind 'zigzag', 'turn', 'straight' or 'other', and its text as in `list_manoeuvres`."""

    kind: str
    text: str
    start: int
    stop: int


Stretch: TypeAlias = tuple[int, int, int]
"""The side of the rudder (1, -1, or 0 amidships), and the samples start:stop of a stretch."""


def cut(record: Record) -> list[tuple[ManoeuvreSegment, Record]]:
    """The manoeuvres of a record, each with its part of the record; the whole record where there is only one."""
    out = []
    counts: dict[str, int] = {}
    for segment in find_segments(record):
        counts[segment.kind] = counts.get(segment.kind, 0) + 1
        part = record.slice(segment.start, segment.stop)
        time = part.time_s - part.time_s[0]
        meta = replace(part.meta, manoeuvre=segment.text or None)
        name = f"{record.name}-{segment.kind}-{counts[segment.kind]}"
        out.append((segment, replace(part, time_s=time, name=name, meta=meta)))
    return out


def find_segments(record: Record) -> list[ManoeuvreSegment]:
    """The manoeuvres of a record in their order; empty where there is no rudder, or it is not known or never laid."""
    known = np.flatnonzero(np.isfinite(record.rudder())) if any(map(record.has, RUDDERS)) else np.zeros(0, dtype=int)
    if known.size < FEWEST:
        return []
    place = np.maximum(np.searchsorted(known, np.arange(record.n), side="right") - 1, 0)
    rudder = record.rudder()[known[place]]  # gaps are filled by the value before
    least = max(LEAST_RAD, SHARE * float(np.quantile(np.abs(rudder), 0.99)))
    # fewest samples amidships of a straight run, rather than on its way to the other side
    with np.errstate(all="ignore"):
        rate = np.abs(np.diff(rudder) / np.diff(record.time_s))
    moving = rate[rate > 0.1 * rate.max()] if rate.size and rate.max() > 0.0 else np.zeros(0)
    crossing = 2.0 * least / float(np.median(moving)) if moving.size else 0.0
    # stretches of one side; short ones amidships belong to the side after them
    shortest = max(FEWEST, math.ceil(CROSSINGS * crossing / record.dt))
    side = np.where(np.abs(rudder) > least, np.sign(rudder), 0.0).astype(int)
    edges = [0, *(np.flatnonzero(np.diff(side)) + 1).tolist(), side.size]
    raw = [(int(side[a]), a, b) for a, b in pairwise(edges)]
    out: list[Stretch] = []
    start = 0
    for own, first, stop in raw:
        short, last = stop - first < (shortest if own == 0 else max(3, shortest // 8)), stop == side.size
        if short and not last:
            continue
        if out and (out[-1][0] == own or (short and last)):
            out[-1] = (*out[-1][:2], stop)
        else:
            out.append((own, start, stop))
        start = stop
    stretches = out
    # stretches grouped: a straight run alone, all between two straight runs together
    groups: list[list[Stretch]] = []
    for stretch in stretches:
        if stretch[0] == 0 or not groups or groups[-1][-1][0] == 0:
            groups.append([stretch])
        else:
            groups[-1].append(stretch)
    found = [_named(record, group) for group in groups]
    return [s for s in found if s.stop - s.start >= MIN_SAMPLES]


def _named(record: Record, group: Sequence[Stretch]) -> ManoeuvreSegment:
    """The manoeuvre of some stretches, with a short run before it; a zigzag without a heading has no text."""
    (side, start, _), (*_, stop) = group[0], group[-1]
    if side == 0:
        return ManoeuvreSegment("straight", "straight", start, stop)
    lead = int(np.searchsorted(record.time_s, record.time_s[start] - LEAD_S))
    found = performed(_with_heading(record.slice(lead, stop)))
    first = side * (-1 if record.meta.positive_rudder == "port" else 1)
    text = f"{found.title.replace(' ', ':')}{':port' if first < 0 else ''}" if found.kind else ""
    return ManoeuvreSegment(found.kind or "other", text, lead, stop)


def _with_heading(record: Record) -> Record:
    """The record, where it has no heading with the integral of its yaw rate."""
    if record.has("heading_rad") or not record.has("yaw_rate_rad_s"):
        return record
    return record.with_channels(heading_rad=integral_over_gaps(record.column("yaw_rate_rad_s"), record.time_s))
