"""Clocks of several loggers set to one: by what the files state, by channels in common, or by the ship's motion."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from .convert import Stream
from .draft import Answer, Question
from .gps_time import EPOCH_S, WEEK_S, leap_seconds
from .offsets import NEAR_S, OVERLAP, Lag, estimate_offset, offset_by_motion
from .result import FileFault
from .times import clock_question

ZONE_STEP_S, LONGEST_ZONE_S = 900.0, 14.0 * 3600.0
"""Steps of the zones of the world, and the largest of them."""
MISSED_S, SURE_S = 5.0, 20.0
"""Seconds by which the motion may miss a zone, and within which an offset that is none must be known."""
SAME_STEPS = 2.0
"""Steps within which two tables begin and end together that one program wrote."""
STARTS_S = 60.0
"""Seconds below which a first time says that the clock was started with the log."""


@dataclass(frozen=True)
class Setting:
    """Seconds to add to a clock, what to say of it, and whether it is in doubt; `rate`, `middle`: as of an `Offset`."""

    seconds: float
    told: str = ""
    doubt: bool = False
    rate: float = 0.0
    middle: float = 0.0

    def of(self, stream: Stream, dated: bool) -> Stream:
        """A stream on the clock that was set."""
        set_ = replace(stream, shift_s=self.seconds, rate=self.rate, middle_s=self.middle, dated=dated)
        return replace(set_, time=set_.on_clock(stream.time))


def on_dates(streams: Sequence[Stream]) -> list[Stream]:
    """The streams; those that count from a midnight or a GPS week put on the day or the week of one with a date."""
    dated = sorted((s for s in streams if s.dated), key=lambda stream: not stream.zoned)
    return [_on_date(s, dated[0]) if dated and s.period_s and not s.dated else s for s in streams]


def _on_date(stream: Stream, other: Stream) -> Stream:
    """A stream on the day or week in which it has most in common with another, in UTC where it states GPS time."""
    ahead = float(leap_seconds(other.time[0])) if stream.gps else 0.0
    origin = (EPOCH_S if stream.period_s == WEEK_S else 0.0) - ahead
    middle = (other.time[0] + other.time[-1]) / 2.0 - (stream.time[0] + stream.time[-1]) / 2.0
    whole = round((middle - origin) / stream.period_s) * stream.period_s
    what = "week" if stream.period_s == WEEK_S else "day"
    gps = f", {ahead:g} s of GPS time taken off" if ahead else ""
    done = (*stream.done, f"{stream.label}: put on the {what} of {other.label}{gps}")
    return replace(stream, time=stream.time + origin + whole, dated=True, zoned=stream.zoned or stream.gps, done=done)


def align(streams: Sequence[Stream]) -> tuple[list[Stream], list[str], list[FileFault], list[Question]]:
    """The streams on one clock, that which states UTC or else of the rudder; what was done, doubts, and questions for
    clocks that nothing tells."""
    clocks: dict[str, list[Stream]] = {}
    for stream in streams:
        clocks.setdefault(stream.clock, []).append(stream)

    def rank(name: str) -> tuple[bool, ...]:
        own = clocks[name]
        of_rudder = any("rudder" in stream.quantities for stream in own)
        return any(stream.zoned for stream in own), any(stream.dated for stream in own), of_rudder

    base = max(clocks, key=rank)
    out, done, faults = list(clocks[base]), [], []
    waiting = [own for name, own in clocks.items() if name != base]
    while waiting:
        tried = [(own, setting) for own in waiting if (setting := _setting(out, own)) is not None]
        if not tried:
            break
        own, setting = min(tried, key=lambda entry: entry[1].doubt)
        out += [setting.of(stream, out[0].dated) for stream in own]
        waiting.remove(own)
        if setting.doubt:
            hint = "give clock_offset_s of this table in the map if it is wrong"
            faults.append(FileFault(own[0].label, setting.told, hint))
        elif setting.told:
            done.append(f"{own[0].label}: {setting.told}")
    return out, done, faults, [_question(out, own) for own in waiting]


def _setting(base: Sequence[Stream], own: Sequence[Stream]) -> Setting | None:
    """What sets the clock of `own` to that of `base`; None where nothing tells it."""
    given = [stream.offset_s for stream in own if stream.offset_s is not None]
    # what the map adds to the clock of the base is taken off the others, where it says nothing of them
    given += [-stream.offset_s for stream in base if stream.offset_s is not None]
    if given:
        return Setting(given[0], f"clock set {given[0]:+g} s as the mapping says")
    shared = estimate_offset(base, own)
    if shared is not None:
        told = f"{shared.seconds:+.3f} s (standard error {shared.stderr:.2g} s, correlation {shared.correlation:.4f})"
        said = f"clock set {told} to that of {base[0].label}, told by {shared.quantity}"
        if not shared.rate:
            return Setting(shared.seconds, said)
        ends = shared.seconds + shared.rate * (own[0].time[[0, -1]] - shared.middle)
        said += f"; it goes {'slow' if shared.rate > 0.0 else 'fast'} by {abs(100.0 * shared.rate):.2g} %: "
        said += f"{ends[0]:+.2f} s at its start, {ends[1]:+.2f} s at its end"
        return Setting(shared.seconds, said, False, shared.rate, shared.middle)
    if all(stream.dated for stream in (*base, *own)):
        return _dated(base, own)
    return _undated(base, own)


def _dated(base: Sequence[Stream], own: Sequence[Stream]) -> Setting | None:
    """The setting of a clock with a date: as it is where both state UTC, or by the zone that the motion tells."""
    label, stated = base[0].label, [all(stream.zoned for stream in streams) for streams in (base, own)]
    lag = _lag(base, own)
    if all(stated):
        return _stated(base, own, lag)
    zones = _zones(base, own)
    able = [] if lag is None else [zone for zone in zones if lag.holds(zone)]
    if lag is not None and len(able) == 1 and abs(able[0] - lag.seconds) <= MISSED_S:
        told = f"clock {f'set {able[0]:+g} s to' if able[0] else 'taken as'} that of {label}: {lag.told} so"
        return Setting(able[0], told, able[0] != 0.0)
    if lag is not None and lag.sharp and not any(abs(zone - lag.seconds) <= MISSED_S for zone in zones):
        return _by_motion(label, lag) if lag.high - lag.low <= SURE_S else None
    if not any(stated) and (lag is None or lag.holds(0.0)):
        return Setting(0.0, f"clock taken as that of {label} (no channel that both hold tells more)")
    return None


def _stated(base: Sequence[Stream], own: Sequence[Stream], lag: Lag | None) -> Setting:
    """The setting of a clock where both state their offset from UTC: none, but for GPS time that may be named so."""
    ahead, vague = float(leap_seconds(base[0].time[0])), any(stream.vague for stream in (*base, *own))
    told = lag if lag is not None and lag.sharp and abs(lag.seconds) > MISSED_S and not lag.holds(0.0) else None
    leap = [seconds for seconds in (-ahead, ahead) if told and told.holds(seconds)]
    if vague and leap and told:
        said = f"its clock or that of {base[0].label} is named GPS time and shows UTC: {told.told} so"
        return Setting(leap[0], f"clock set {leap[0]:+g} s: {said}", True)
    if told:
        said = f"{told.told} best with its clock {told.seconds:+.1f} s, but both tables state their offset from UTC"
        return Setting(0.0, f"{said}: left as it is", True)
    if vague and lag is None:
        said = f"GPS time is taken as such, {ahead:g} s ahead of UTC: nothing tells whether it is UTC"
        return Setting(0.0, said, True)
    return Setting(0.0, f"clock taken as that of {base[0].label}, both state their offset from UTC")


def _lag(base: Sequence[Stream], own: Sequence[Stream]) -> Lag | None:
    """The offset that the motion tells, near to the zones with which two clocks have enough in common."""
    for zone in _common_zones(base, own):
        moved = [replace(stream, time=stream.time + zone) for stream in own]
        lag = offset_by_motion(base, moved, NEAR_S)
        if lag is not None:
            return replace(lag, seconds=lag.seconds + zone, low=lag.low + zone, high=lag.high + zone)
    return None


def _undated(base: Sequence[Stream], own: Sequence[Stream]) -> Setting | None:
    """The setting of a clock without a date: by the motion, or as it is where both count from one moment."""
    label, lag = base[0].label, offset_by_motion(base, own, None)
    if lag is not None and lag.sharp:
        return _by_motion(label, lag)
    alike = not any(stream.dated for stream in (*base, *own)) and base[0].period_s == own[0].period_s
    late = min(base[0].time[0], own[0].time[0]) > STARTS_S and _overlap(base, own)
    if alike and (late or _same_ends(base[0], own[0])):
        said = f"clock taken as that of {label}, whose times have the same size: nothing else tells it"
        return Setting(0.0, said, True)
    return None


def _same_ends(one: Stream, other: Stream) -> bool:
    """Whether two tables begin and end together, within some steps, and not at zero, where every clock may begin."""
    step = max(float(np.median(np.diff(s.time))) if s.time.size > 1 else 0.0 for s in (one, other))
    apart = np.abs(one.time[[0, -1]] - other.time[[0, -1]])
    return bool(np.all(apart <= SAME_STEPS * step)) and min(one.time[0], other.time[0]) > SAME_STEPS * step


def _by_motion(label: str, lag: Lag) -> Setting:
    sure = max(lag.high - lag.seconds, lag.seconds - lag.low)
    told = f"clock set {lag.seconds:+.1f} s, to some {max(1.0, math.ceil(sure)):g} s, to that of {label}: {lag.told} so"
    return Setting(lag.seconds, told, True)


def _overlap(base: Sequence[Stream], own: Sequence[Stream]) -> bool:
    """Whether two clocks show times of which enough are the same."""
    ends = [(min(s.time[0] for s in streams), max(s.time[-1] for s in streams)) for streams in (base, own)]
    (first, last), (start, stop) = ends
    return min(last, stop) - max(first, start) > OVERLAP * min(last - first, stop - start)


def _common_zones(base: Sequence[Stream], own: Sequence[Stream]) -> list[float]:
    """Seconds of the zones with which two clocks with a date have enough in common: 0, or else those with the most."""
    if _overlap(base, own):
        return [0.0]
    middle = np.mean([base[0].time[0], base[0].time[-1]]) - np.mean([own[0].time[0], own[0].time[-1]])
    near = ZONE_STEP_S * round(float(middle) / ZONE_STEP_S)
    zones = [near + k * ZONE_STEP_S for k in (0, -1, 1, -2, 2)]
    moved = {zone: [replace(stream, time=stream.time + zone) for stream in own] for zone in zones}
    return [zone for zone in zones if 0.0 < abs(zone) <= LONGEST_ZONE_S and _overlap(base, moved[zone])]


def _zones(base: Sequence[Stream], own: Sequence[Stream]) -> list[float]:
    """Seconds by which a clock with a date may be off: zones, and GPS time where it or the other states none."""
    ahead = float(leap_seconds(base[0].time[0]))
    zones = _common_zones(base, own)
    return [zone + more for more in (0.0, -ahead, ahead) for zone in zones]


def _meaning(seconds: float, base: Sequence[Stream]) -> str:
    """What it means that seconds are to be added to a clock with a date."""
    ahead = float(leap_seconds(base[0].time[0]))
    zone = ZONE_STEP_S * round(seconds / ZONE_STEP_S)
    rest = {0.0: "", -ahead: f"{ahead:g} s ahead, as GPS time is of UTC",
            ahead: f"{ahead:g} s behind, as UTC is of GPS time"}[seconds - zone]  # fmt: skip
    hours = f"its zone is {abs(zone) / 3600.0:g} h {'behind' if zone > 0.0 else 'ahead'}" if zone else ""
    return ", ".join(part for part in (hours, rest) if part) or "none: both show the same time"


def _question(base: Sequence[Stream], own: Sequence[Stream]) -> Question:
    """The question for the offset of a clock that nothing tells."""
    label, reference = own[0].label, base[0].label
    dated = all(stream.dated for stream in (*base, *own))
    if dated:
        texts = {zone: _meaning(zone, base) for zone in _zones(base, own) or [0.0]}
    else:
        texts = {float(f"{base[0].time[0] - own[0].time[0]:.12g}"): "that by which both tables begin together"}
        if base[0].dated == own[0].dated:
            texts |= {0.0: "none: both count from the same moment"}
    why = "One of them states no offset from UTC" if dated else "No date"
    said = f"{why}, no channel is in common, and the motion does not tell it."
    text = f"By how much is the clock of {label} off that of {reference}? {said}"
    made = tuple(Answer(f"{seconds:.12g}", said, f"clock_offset_s: {seconds:.12g}") for seconds, said in texts.items())
    number = "seconds to add to its times: clock_offset_s: NUMBER"
    table = own[0].table
    return Question(clock_question(table), "time", table, own[0].time_column, text, made, number)
