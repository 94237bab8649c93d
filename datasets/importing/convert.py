"""A raw table and its mapping as quantities in SI units and radians over seconds, and these as channels of a record."""

from __future__ import annotations

import math
from collections.abc import Mapping as Dict
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from ..columns import RUDDERS, TWIN
from ..geometry import body_velocities, on_plane
from ..io import MIN_SAMPLES
from .draft import NOT_USED, Question
from .finding import EITHER_SIDE, either_side
from .mapping import ColumnMap, TableMap
from .quantities import UNITS, quantities
from .raw import RawColumn, RawTable
from .result import FileFault
from .times import TableTime

FEW, UNLIKE, MANY, HALF = 0.02, 0.1, 0.2, 0.5
"""Share of rows that may be left out for their time, of those for their number of cells, of cells of a column that may
be gaps for not being numbers, and of sentences or messages: their checksums tell the bad ones from the others."""
MOST_RUNS = 50
"""Runs of a table; a time that starts again more often is not sorted."""
HOLE_S, HOLE_STEPS, LATE_STEPS = 60.0, 60.0, 5.0
"""Seconds, and median steps, without rows from which on it is told; how much longer than nearly all steps one is that
is told, too."""


@dataclass(frozen=True)
class Stream:
    """Quantities of one logger, each (N,), over its time (N,) s; `kept` are the rows of the table that they come from.

    dated : whether the time counts from 1970;  clock : streams with an equal text share a clock;
    offset_s : what the mapping says is to be added to the time, None where it says nothing.
    """

    label: str
    clock: str
    dated: bool
    time: np.ndarray
    quantities: Dict[str, np.ndarray]
    kept: np.ndarray
    offset_s: float | None = None
    done: tuple[str, ...] = ()
    shift_s: float = 0.0
    rate: float = 0.0
    middle_s: float = 0.0
    """What was added to its times t, s, to set the clock: shift_s + rate (t - middle_s)."""
    parts: tuple[str, ...] = ()
    """Labels of streams that were joined to this one."""
    zoned: bool = False
    """Whether the file states the offset of its times from UTC."""
    period_s: float = 0.0
    """Seconds after which times without a date are the same again; 0 where they are not."""
    gps: bool = False
    """Whether the file states GPS time; where it states the date, too, the times are in UTC."""
    vague: bool = False
    """Whether GPS time is told by a name that stands for the receiver's UTC as well."""
    time_column: str = ""
    """Column of the time, '' for none."""
    run: int = 0
    """Number of the run, where the time of the table starts again; else 0."""

    def at(self, rows: np.ndarray | slice) -> Stream:
        """Some rows of the stream."""
        own = {name: values[rows] for name, values in self.quantities.items()}
        return replace(self, time=self.time[rows], quantities=own, kept=self.kept[rows])

    def on_clock(self, time: np.ndarray) -> np.ndarray:
        """Times (N,), s, of this clock before it was set, as they are after that."""
        return time + self.shift_s + self.rate * (time - self.middle_s)

    @property
    def table(self) -> str:
        """Label of its table."""
        return self.label.removesuffix(f", run {self.run}")

    @property
    def step(self) -> float:
        """Median time step, s."""
        return float(np.median(np.diff(self.time)))


def streams_of(table: RawTable, mapping: TableMap, times: TableTime) -> tuple[list[Stream], list[FileFault]]:
    """The quantities of a table, of every run of it where its time starts again, and its faults; none where a fault is
    fatal."""
    faults = []
    if table.faults:  # one for all rows that the reader left out
        total = max(table.lines, table.n + len(table.faults))
        many = len(table.faults) > (HALF if table.lines else UNLIKE) * total and len(table.faults) > 2
        row, message, _ = next(iter(table.faults))
        more = f" ({len(table.faults)} of {total} rows are wrong, this is the first)" if len(table.faults) > 1 else ""
        hint = "mend or remove them" if many else "left out"
        faults.append(FileFault(table.label, message + more, hint, row=row, fatal=many))
    seconds = times.seconds(table)
    assert seconds is not None
    time, done = seconds
    parts, wrong = _usable_rows(table, time, mapping)
    faults += wrong
    quantities = {}
    for entry in mapping.columns:
        column = table.column(entry.column)
        if column is None or entry.to == NOT_USED or entry.open:
            continue
        quantities[entry.to], found = _converted(table, column, entry)
        faults += found
    if any(fault.fatal for fault in faults) or max(map(len, parts), default=0) < 3:
        return [], faults
    offset = mapping.clock_offset_s if mapping.clock_offset_s is not None else times.offset_s
    made = Stream(
        table.label, table.clock, times.dated, time, quantities, np.arange(time.size), offset,
        (f"{table.label}: {done}",) if done else (), zoned=times.zoned, period_s=times.period_s,
        gps=times.scale == "GPS", vague=times.vague,
        time_column=next(iter(mapping.time.columns), ""),
    )  # fmt: skip
    streams = [made.at(kept) for kept in parts]
    if len(parts) > 1:
        streams = [replace(s, label=f"{s.label}, run {run}", run=run) for run, s in enumerate(streams, 1)]
    hint = "was the log cut, or its clock set (summer time)? cut the record there"
    for stream in streams:  # the longest time without rows, where it is that of many
        steps = np.diff(stream.time)
        k = int(np.argmax(steps))
        long = min(max(HOLE_S, HOLE_STEPS * np.median(steps)), LATE_STEPS * np.quantile(steps, 0.99))
        if steps[k] > long:
            said, row = f"no row for {steps[k]:.4g} s before this one", int(table.rows[stream.kept[k + 1]])
            faults.append(FileFault(table.label, said, hint, row))
    return streams, faults


def _usable_rows(table: RawTable, time: np.ndarray, mapping: TableMap) -> tuple[list[np.ndarray], list[FileFault]]:
    """(indices of rows with times that rise, of every run; faults)."""
    name = mapping.time.columns[-1] if mapping.time.columns else None
    faults: list[FileFault] = []
    known = np.flatnonzero(np.isfinite(time))
    missing = np.flatnonzero(~np.isfinite(time))
    if missing.size:
        many = missing.size > FEW * time.size and missing.size > 2
        said = f"{missing.size} of {time.size} rows have no time of the form {mapping.time.form!r}"
        hint = "state the form in the mapping" if many else "left out"
        faults.append(FileFault(table.label, said, hint, int(table.rows[missing[0]]), name, many))
    if known.size < 3:
        said, hint = f"{known.size} rows with a time", "a log needs some minutes of them"
        return [known], [*faults, FileFault(table.label, said, hint, column=name, fatal=True)]
    parts = _runs_of(time, known)
    rises = [np.diff(np.maximum.accumulate(time[part]), prepend=-np.inf) > 0.0 for part in parts]
    kept = [part[own] for part, own in zip(parts, rises, strict=True)]
    late = np.concatenate([part[~own] for part, own in zip(parts, rises, strict=True)])
    back = late[time[late] < time[late - 1]]
    if back.size:
        many = late.size > FEW * time.size
        said = f"time goes back in {back.size} place{'s' if back.size > 1 else ''}"
        hint = "cut the file there, or sort it by time" if many else f"{late.size} rows left out"
        faults.append(FileFault(table.label, said, hint, int(table.rows[back[0]]), name, many))
    elif late.size:
        many = late.size > 0.5 * time.size
        hint = "the time is too coarse: log it with fractions of a second" if many else "the first of each was kept"
        said = f"{late.size} rows repeat the time of the row before"
        faults.append(FileFault(table.label, said, hint, int(table.rows[late[0]]), name, many))
    long = [part for part in kept if part.size >= MIN_SAMPLES]
    if len(parts) > 1 and long:
        said = f"time goes back here, and at {len(parts) - 2} later places: cut into {len(long)} runs of their own"
        said = said.replace(", and at 0 later places", "")
        short = sum(part.size for part in kept) - sum(part.size for part in long)
        hint = "a record each" + (f"; {short} rows in runs too short for one left out" if short else "")
        faults.append(FileFault(table.label, said, hint, int(table.rows[parts[1][0]]), name))
    return long if len(parts) > 1 and long else kept, faults


def _runs_of(time: np.ndarray, known: np.ndarray) -> list[np.ndarray]:
    """Rows with a time (N,) cut where it starts again: it goes back, and is not soon where it was before."""
    rest, parts = known, []
    while len(parts) < MOST_RUNS:
        times = time[rest]
        highest = np.maximum.accumulate(times)
        back = np.flatnonzero(np.diff(times) < 0.0) + 1
        before = highest[back - 1]
        later = np.searchsorted(highest, before, side="right") - back
        again = before - times[back] > HALF * (before - times[0])
        cuts = back[(later >= MIN_SAMPLES) & ((later > FEW * known.size) | again)]
        if not cuts.size:
            return [*parts, rest]
        parts, rest = [*parts, rest[: cuts[0]]], rest[cuts[0] :]
    return [known]


def _converted(table: RawTable, column: RawColumn, entry: ColumnMap) -> tuple[np.ndarray, list[FileFault]]:
    """The column in SI units, and a fault where cells are no numbers."""
    numbers, bad = column.numbers, column.bad
    if entry.unit == "deg min":
        numbers, bad = column.degrees, np.flatnonzero(~np.isfinite(column.degrees))
    unit = UNITS[str(entry.unit)].factor
    numbers = np.where(np.isfinite(numbers), numbers, np.nan)
    values = numbers * (unit * entry.factor * int(entry.sign)) + entry.offset * unit
    values = either_side(values) if entry.to in EITHER_SIDE else values
    empty = not np.isfinite(values).any()
    if empty:
        hint = "check its cells, or leave it out of the mapping"
        return values, [FileFault(table.label, "no number in the whole column", hint, column=column.name, fatal=True)]
    if not bad.size:
        return values, []
    many = bad.size > MANY * values.size
    said = f"{column.text(bad[0])!r} is not a number ({bad.size} such cells)"
    hint = "map another column, or write what it means as an empty cell" if many else "taken as gaps"
    return values, [FileFault(table.label, said, hint, int(table.rows[bad[0]]), column.name, many)]


# ---- The channels of a record from the quantities of a log.


class Channels:
    """Channels in the making: `found` by name, the quantities that each is made of in `sources`, what was done in
    `steps`, faults, questions, and facts for the sidecar."""

    def __init__(self, label: str, time: np.ndarray, values: dict[str, np.ndarray]) -> None:
        self.label, self.time, self.q = label, time, values
        self.found: dict[str, np.ndarray] = {}
        self.sources: dict[str, tuple[str, ...]] = {}
        self.steps: list[str] = []
        self.faults: list[FileFault] = []
        self.questions: list[Question] = []
        self.facts: dict[str, Any] = {}
        self.variation: float | None = None
        for quantity, samples in values.items():
            if channel := quantities()[quantity].channel:
                self.add((quantity,), **{channel: samples})

    def add(self, sources: tuple[str, ...], **channels: np.ndarray) -> None:
        """Add channels (N,) that are made of quantities."""
        self.found |= channels
        self.sources |= dict.fromkeys(channels, sources)

    def warn(self, message: str, hint: str = "") -> None:
        """Add a fault that does not end the import."""
        self.faults.append(FileFault(self.label, message, hint))


def derive(label: str, time: np.ndarray, values: dict[str, np.ndarray], variation_deg: float | None) -> Channels:
    """All channels that quantities give, each (N,).

    variation_deg : magnetic variation, positive to east, for a magnetic heading without one in the log.
    """
    made = Channels(label, time, values)
    q = made.q
    if "heading" in q:
        made.add(("heading",), heading_rad=q["heading"])
    elif "heading_magnetic" in q:
        variation = q.get("magnetic_variation")
        size = np.nanmean(variation) if variation is not None else math.radians(variation_deg or 0.0)
        made.variation = float(size) if variation is not None or variation_deg is not None else None
        deviation = q.get("magnetic_deviation", np.zeros(made.time.size))
        known = np.isfinite(deviation)  # of each heading another one
        correction = size + np.where(known, deviation, deviation[known].mean() if known.any() else 0.0)
        sources = ("heading_magnetic", "magnetic_variation", "magnetic_deviation")
        made.add(sources, heading_rad=q["heading_magnetic"] + correction)
        degrees = math.degrees(float(correction.mean()))
        made.steps.append(f"heading: magnetic heading {degrees:+.3g} deg of variation, deviation")
    _positions(made)
    _velocities(made)
    found = made.found
    if set(TWIN) <= found.keys() and not set(RUDDERS) & found.keys():
        made.add(("thrust_port", "thrust_starboard"), **{RUDDERS[1]: found[TWIN[0]] - found[TWIN[1]]})
        made.steps.append("steering command: port less starboard thrust, N; there is no rudder")
    for name in values:
        other = quantities()[name].partner
        if other and other not in values:
            made.warn(f"{name.replace('_', ' ')} without {other.replace('_', ' ')}: it makes no channel of the record")
    return made


def _positions(made: Channels) -> None:
    q = made.q
    if "north" in q and "east" in q:
        made.add(("north",), north_m=q["north"])
        made.add(("east",), east_m=q["east"])
        return
    if "latitude" not in q or "longitude" not in q:
        return
    valid = np.isfinite(q["latitude"]) & np.isfinite(q["longitude"])
    nothing = valid & (q["latitude"] == 0.0) & (q["longitude"] == 0.0)
    if nothing.any():
        made.warn(f"{int(nothing.sum())} positions at 0 N 0 E", "taken as gaps: a receiver without a fix")
    if not (valid & ~nothing).any():
        return
    latitude, longitude = (np.where(nothing, np.nan, q[name]) for name in ("latitude", "longitude"))
    north, east, plane = on_plane(latitude, longitude)
    made.add(("latitude", "longitude"), north_m=north, east_m=east)
    origin = math.degrees(plane.latitude_rad), math.degrees(plane.longitude_rad)
    made.facts["origin_deg"] = [round(value, 8) for value in origin]
    made.steps.append(
        f"north, east: plane through {origin[0]:.6f}, {origin[1]:.6f} deg; distances to {plane.scale_error:.1g} of "
        f"their size, plane north to {math.degrees(plane.convergence_rad):.2g} deg; at the receiver's antenna"
    )


def _velocities(made: Channels) -> None:
    q, heading = made.q, made.found.get("heading_rad")
    if "surge" in q:
        for name in ("surge", "sway"):
            if name in q:
                made.add((name,), **{f"{name}_m_s": q[name]})
        return
    if "velocity_north" in q and "velocity_east" in q:
        parts, told = (q["velocity_north"], q["velocity_east"]), "velocities to north and east"
        of = ("velocity_north", "velocity_east")
    elif "speed_over_ground" in q and "course_over_ground" in q:
        speed, course = q["speed_over_ground"], q["course_over_ground"]
        parts, told = (speed * np.cos(course), speed * np.sin(course)), "speed and course over ground"
        of = ("speed_over_ground", "course_over_ground")
    elif "speed_over_ground" in q:
        made.warn("a speed over ground without a course: surge and sway cannot be told apart", "speed kept aside")
        return
    else:
        return
    if heading is None:
        made.warn(f"{told} without a heading: surge and sway cannot be told apart", "kept aside")
        return
    surge, sway = body_velocities(*parts, heading)
    made.add((*of, *made.sources["heading_rad"]), surge_m_s=surge, sway_m_s=sway)
    made.steps.append(f"surge, sway: {told}, turned by the heading; at the receiver's antenna")
