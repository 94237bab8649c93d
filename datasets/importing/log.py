"""The findings of all tables of a log, with their times: what one column can be compared with, and the answers to the
questions about them."""

from __future__ import annotations

import json
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from ...models.data_file import yaml_of
from ...models.errors import BadInput
from ..geometry import on_plane, unwrapped
from .draft import NOT_USED, Answer, Question
from .evidence import ClockSeries, together, track_velocity
from .finding import ColumnFinding
from .mapping import ColumnMap
from .quantities import UNITS, LogUnit, is_unsigned, quantities
from .reading import goes_ahead
from .times import TableTime


@dataclass
class RawLog:
    """Findings of all columns, the times of their tables by label, the keys of answers by question, and what is asked
    of columns of a table together."""

    findings: list[ColumnFinding]
    times: dict[str, TableTime]
    answers: Mapping[str, str]
    proposals: list[Question] = field(default_factory=list)
    _seconds: dict[tuple[str, TableTime], np.ndarray | None] = field(default_factory=dict)
    _velocities: dict[tuple[object, ...], tuple[ClockSeries, ClockSeries] | None] = field(default_factory=dict)

    def answered(self, found: ColumnFinding) -> ColumnFinding:
        """A finding with what the answers to its questions say."""
        for question in found.questions:
            key = self.answers.get(question.id)
            if key is not None:
                rest = tuple(q for q in found.questions if q is not question)
                found = _with_answer(replace(found, questions=rest), question, key)
        return found

    def each(self, *steps: Callable[[RawLog, ColumnFinding], ColumnFinding]) -> None:
        """Take steps, each for every finding that is used; a question that has its answer is settled."""
        for step in steps:
            for i, found in enumerate(self.findings):
                if found.may_be:
                    self.findings[i] = self.answered(step(self, found))

    def change(self, found: ColumnFinding, made: ColumnFinding) -> None:
        """Put another finding of a column in the place of one."""
        self.findings = [made if f is found else f for f in self.findings]

    def seconds(self, finding: ColumnFinding) -> np.ndarray | None:
        """(N,) times of the finding's table, s; None where no time is known."""
        key = finding.table.label, self.times[finding.table.label]
        if key not in self._seconds:
            found = key[1].seconds(finding.table)
            self._seconds[key] = None if found is None else found[0]
        return self._seconds[key]

    def series(self, finding: ColumnFinding, unit: LogUnit | None = None, raw: bool = False) -> ClockSeries | None:
        """The values of a finding over time: in SI units, with another unit if one is given, or as in the file."""
        time = self.seconds(finding)
        if time is None:
            return None
        values = finding.column.numbers if raw else finding.values(unit)
        return ClockSeries(time, values, finding.table.clock, self.times[finding.table.label].dated)

    def all(self, *wanted: str, signed: bool = True) -> Iterator[tuple[ColumnFinding, ClockSeries]]:
        """Findings of quantities whose unit (and sign) is known, with their series."""
        for finding in self.findings:
            if finding.quantity in wanted and finding.unit is not None and (finding.signed or not signed):
                series = self.series(finding)
                if series is not None and np.isfinite(series.values).any():
                    yield finding, series

    def first(self, *wanted: str, signed: bool = True) -> tuple[ColumnFinding, ClockSeries] | None:
        """The first of them."""
        return next(self.all(*wanted, signed=signed), None)

    def tracks(self) -> Iterator[tuple[str, ClockSeries, ClockSeries]]:
        """(name, velocity to north, velocity to east) of all positions and velocities over ground that are known."""
        kinds = (("velocity_north", "velocity_east"), ("latitude", "longitude"), ("north", "east"),
                 ("speed_over_ground", "course_over_ground"))  # fmt: skip
        for kind in kinds:
            for (first, one), (second, other) in self.beside(*kind):
                velocity = (one, other) if kind[0] == "velocity_north" else None
                if kind[0] == "latitude":  # computed once for equal units, signs and times
                    columns = id(first.column), id(second.column), id(one.time)
                    key = (*columns, first.unit, second.unit, first.sign, second.sign)
                    shared = together(one, other) if key not in self._velocities else None
                    if shared is not None and np.abs(shared[1]).max() <= 1.58:
                        plane = on_plane(*shared[1:])[:2]
                        velocity = track_velocity(*(replace(one, time=shared[0], values=x) for x in plane))
                    velocity = self._velocities.setdefault(key, velocity)
                elif kind[0] == "north":
                    velocity = track_velocity(one, other)
                elif kind[0] == "speed_over_ground" and (shared := together(one, other, angle_second=True)) is not None:
                    time, size, angle = shared
                    north = replace(one, time=time, values=size * np.cos(angle))
                    velocity = north, replace(north, values=size * np.sin(angle))
                if velocity is not None:
                    yield f"{first.column.name}, {second.column.name}", *velocity

    def axes(self) -> Iterator[tuple[str, ClockSeries, ClockSeries]]:
        """(name, velocity along the first axis, along the second) of positions in a plane of which it is open which one
        is that to north: their speed, and their course but for its sense, are those of a track."""
        for first in self.findings:
            pair = first.quantity is None and first.may_be == ("north", "east") and first.unit is not None
            second = next((f for f in self.findings if f.table is first.table and f.may_be == ("east", "north")), None)
            if not pair or second is None or second.unit is None:
                continue
            x, y = self.series(first), self.series(second)
            velocity = track_velocity(x, y) if x is not None and y is not None else None
            if velocity is not None:
                yield f"{first.column.name}, {second.column.name}", *velocity

    def beside(
        self, one: str, other: str
    ) -> Iterator[tuple[tuple[ColumnFinding, ClockSeries], tuple[ColumnFinding, ClockSeries]]]:
        """Pairs of two quantities of comparable clocks."""
        others = list(self.all(other))
        for first in self.all(one):
            second = next((pair for pair in others if first[1].comparable(pair[1])), None)
            if second is not None:
                yield first, second

    def turns(
        self, tracks: Iterable[tuple[str, ClockSeries, ClockSeries]] | None = None
    ) -> Iterator[tuple[str, ClockSeries]]:
        """(name, course of a track, rad, without jumps) of all tracks, or of some."""
        for name, north, east in self.tracks() if tracks is None else tracks:
            shared = together(north, east)
            if shared is not None:
                time, n, e = shared
                moving = np.hypot(n, e) > 0.2 * np.quantile(np.hypot(n, e), 0.9)
                course = np.where(moving, np.arctan2(e, n), np.nan)
                yield name, ClockSeries(time, unwrapped(course), north.clock, north.dated)


def speeds(tracks: Sequence[tuple[str, ClockSeries, ClockSeries]]) -> Iterator[tuple[str, ClockSeries]]:
    """(name, speed over ground, m/s) of tracks."""
    for name, north, east in tracks:
        shared = together(north, east)
        if shared is not None:
            yield name, ClockSeries(shared[0], np.hypot(shared[1], shared[2]), north.clock, north.dated)


def _with_answer(found: ColumnFinding, question: Question, key: str) -> ColumnFinding:
    answer = question.answer(key) or _as_number(question, key)
    if answer is None:
        known = ", ".join(answer.key for answer in question.answers)
        raise BadInput(f"{key!r} is no answer to {question.id!r}", hint=f"give one of: {known}")
    entry = ColumnMap.model_validate(yaml_of(answer.line.encode(), "answer")[0][0])
    if entry.to == NOT_USED:
        return found.unused("not used, as answered")
    base = replace(found, sure="stated", why=(*found.why, "as answered"), bounded=(*found.bounded, question.about))
    if question.about == "unit":
        unit = UNITS.get(str(entry.unit))
        return replace(base, unit=unit, factor=entry.factor, offset=entry.offset, foreign="")
    if question.about == "numbers":
        return replace(base, factor=entry.factor)
    if question.about == "sign":
        return replace(base, signed=True, sign=1 if entry.sign == "?" else entry.sign, offset=entry.offset)
    may_be = (entry.to,)
    same = quantities()[entry.to].dimension == base.dimension
    chosen = replace(base, may_be=may_be, unit=base.unit if same else None)
    signed = base.signed if len(found.may_be) == 1 else is_unsigned(entry.to) or goes_ahead(chosen)
    return replace(chosen, signed=signed)


def _as_number(question: Question, key: str) -> Answer | None:
    """The answer that a number is: the first one with a factor, as much larger."""
    try:
        size = float(key)
    except ValueError:
        return None
    scaled = next((a for a in question.answers if "factor:" in a.line or question.number), None)
    if not question.number or scaled is None or not size:
        return None
    made = next((a for a in question.answers if a.key.replace(".", "", 1).isdigit()), scaled)
    entry = yaml_of(made.line.encode(), "answer")[0][0]
    entry["factor"] = entry.get("factor", 1.0) * size / float(made.key)
    entry["offset"] = entry.get("offset", 0.0) * size / float(made.key)
    return Answer(key, f"{size:g}", f"- {json.dumps(entry)}")
