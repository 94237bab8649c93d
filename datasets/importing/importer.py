"""The chain of an import: raw tables, mapping, quantities, one time base, records."""

from __future__ import annotations

import datetime
import math
import os
from collections import Counter
from collections.abc import Iterator, Sequence
from collections.abc import Mapping as Dict
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from ...models.errors import BadInput
from ..axes import track_of
from ..columns import RUDDERS, TWIN
from ..io import MAY_BE_CONSTANT, MIN_SAMPLES
from ..plausibility import doubts
from ..record import Record, RecordMeta, Side, is_side
from ..rudder_sign import rudder_sign_doubt, steering_side
from . import proposal, scales, signs_told, steering, vessels
from .clock import FORMS, seconds, spread
from .clocks import on_dates
from .convert import Stream, streams_of
from .derive import derive
from .draft import NOT_USED, TIME, Answer, DraftColumn, Question, asked_once
from .finding import AS_RECORD, ColumnFinding
from .guess import entry_of, examine, missing, stated_side
from .log import RawLog
from .mapping import ColumnMap, Mapping, TableMap, TimeMap, uses
from .merge import Merged, merge
from .quantities import quantities
from .raw import RawColumn, RawTable
from .reading import WITHOUT_NAME
from .result import Aside, FileFault, Import, ImportFault, ImportReport, channel_sources, refuse_fatal
from .sources import read_raw
from .times import TableTime

RUDDER_SIDE, VARIATION = "rudder side", "variation"
"""Ids of the questions for the side of a positive rudder, and for the magnetic variation."""
LED_BY_TRACK = {"latitude", "north", "velocity_north", "speed_over_ground"}
"""Quantities of the logger that leads a run without rudder, heading and yaw rate."""
ASKEW_RAD = 0.35
"""Mean angle of the track to the heading that is told."""
SAME_RUN = 5.0
"""Steps after its end within which another file of the same columns goes on with a run."""


@dataclass(frozen=True)
class ImportOptions:
    """What the user says besides the mapping; None: told by the log or left open."""

    vessel: str | None = None
    positive_rudder: Side | None = None
    step_s: float | None = None
    variation_deg: float | None = None


@dataclass(frozen=True)
class Drafted:
    """What the columns of a log are taken for; `mapping` the same as a file, with '?' where something is open.

    columns : every column of every table.  questions : of columns, tables and the whole log.  faults : of the files.
    """

    columns: tuple[DraftColumn, ...]
    questions: tuple[Question, ...]
    mapping: Mapping | None
    faults: tuple[FileFault, ...]


def draft_tables(
    tables: Sequence[RawTable], mapping: Mapping | None, options: ImportOptions, answers: Dict[str, str]
) -> tuple[Drafted, Import | ImportFault]:
    """What every column of a log is taken for with the questions that are open; and the import, or whatever keeps the
    logs from being records, all faults and open questions at once.

    Parameters
    ----------
    tables : of one logger or several, of one run or several.
    mapping : what the columns are; None: told by the log.
    answers : id of a question -> key of its answer.
    """
    try:
        return _imported(tables, mapping, options, answers)
    except ImportFault as error:
        return Drafted(error.columns, error.questions, error.draft, error.faults), error


def raw_series(tables: Sequence[RawTable], drafted: Drafted, label: str, name: str) -> tuple[np.ndarray, np.ndarray]:
    """Times (N,), s, or row numbers where no time is known, and the numbers (N,) of a column; BadInput for no such."""
    chosen, _ = chosen_parts(tables, drafted.mapping, {})
    table = next((table for table in chosen if table.label == label), None)
    column = table.column(name) if table is not None else None
    if table is None or column is None:
        raise BadInput(f"no column {name!r} in {label!r}")
    times = [row.column for row in drafted.columns if row.table == label and row.quantity == TIME]
    form = next((row.unit for row in drafted.columns if row.table == label and row.quantity == TIME), None)
    if form not in FORMS:
        return np.arange(table.n, dtype=float), column.numbers
    return spread(seconds([c for n in times if (c := table.column(n))], form))[0], column.numbers


def chosen_parts(
    tables: Sequence[RawTable], mapping: Mapping | None, answers: Dict[str, str]
) -> tuple[list[RawTable], list[Question]]:
    """The tables with the rows of one vessel and the columns of one scale, and the questions which ones are wanted."""
    tables, vessel = vessels.of_one_vessel(tables, mapping, answers)
    if vessel is not None:
        return tables, [vessel]
    tables, scale = scales.of_one_scale(tables, mapping, answers)
    return tables, [scale] if scale is not None else []


def _imported(
    tables: Sequence[RawTable], mapping: Mapping | None, options: ImportOptions, answers: Dict[str, str]
) -> tuple[Drafted, Import]:
    tables, chosen = chosen_parts(tables, mapping, answers)
    log = examine(tables, mapping, answers)
    drafted = _draft(tables, mapping, log, answers)
    if chosen:  # what else is asked depends on the answer
        drafted = replace(drafted, columns=_with_questions(drafted.columns, chosen), questions=tuple(chosen))
        drafted = replace(drafted, mapping=_opened(drafted.mapping, time=chosen[0].id == vessels.VESSEL))
    rows, draft = drafted.columns, drafted.mapping
    faults = list(drafted.faults)
    said = _options(mapping, options, answers)
    streams: list[Stream] = []
    used = draft.tables if draft is not None else ()
    for table in tables:
        entry = next((e for e in used if e.label == table.label), None)
        if entry is not None and entry.time.form != "?" and uses(entry):
            made, found = streams_of(table, entry, log.times[table.label])
            faults += found
            streams += made
    streams = on_dates(streams)
    longest = max(streams, key=lambda stream: stream.time.size, default=None)
    if longest is not None and longest.time.size < MIN_SAMPLES:
        few = f"{longest.time.size} samples"
        faults.append(FileFault(longest.label, few, f"a record needs {MIN_SAMPLES}", fatal=True))
    refuse_fatal(faults, rows, draft, () if any(fault.fatal for fault in faults) else drafted.questions)
    if longest is None:
        empty = FileFault(tables[0].label, "no row has a time and a value", "check the column of the time", fatal=True)
        refuse_fatal([*faults, empty], rows, draft)
    steps = [f"{table.label}: {', '.join(table.done)}" for table in tables if table.done]
    records, aside, questions, sources = [], {}, [], []
    sorted_out = runs(streams)
    faults += _without_use(tables, streams, [stream for _, run in sorted_out for stream in run], used)
    for name, run in sorted_out:
        merged, found, open_clocks = merge(run, said.step_s)
        faults += found
        questions += open_clocks
        if merged is None:
            continue
        record, done, found, asked, made_of = _record(name, merged, said, log)
        steps += done
        faults += found
        questions += asked
        if record is not None:
            records.append(record)
            parts = {label for stream in merged.streams for label in (stream.label, *stream.parts)}
            own = [row for row in rows if row.table in parts]
            sources += channel_sources(name, list(record.channels), made_of, own)
        aside |= _aside(merged, streams, tables, used)
    if any(stream.run for stream in streams):
        records, questions = _same_side(records, questions)
    asked = tuple(dict.fromkeys(questions))
    refuse_fatal(faults, _with_questions(rows, asked) if asked else rows, draft, asked)
    side = next((r.meta.positive_rudder for r in records), None)
    facts = {"vessel": said.vessel, "step_s": said.step_s, "magnetic_variation_deg": said.variation_deg}
    assert draft is not None
    made = draft.model_copy(update={"positive_rudder": said.positive_rudder or side, **facts})
    rows = tuple(replace(r, sign=f"positive to {side}") if side and r.sign == AS_RECORD else r for r in rows)
    report = ImportReport(rows, tuple(steps), tuple(faults), tuple(sources))
    return replace(drafted, columns=rows, mapping=made, faults=tuple(faults)), Import(
        tuple(records), made, report, aside
    )


def _same_side(records: Sequence[Record], questions: Sequence[Question]) -> tuple[list[Record], list[Question]]:
    """The runs of a table, all with the side of a positive rudder that some of them tell, and what is asked."""
    sides = {record.meta.positive_rudder for record in records} - {None}
    if len(sides) != 1:
        return list(records), list(questions)
    side = sides.pop()
    same = [replace(record, meta=replace(record.meta, positive_rudder=side)) for record in records]
    return same, [question for question in questions if question.id != RUDDER_SIDE]


def _without_use(
    tables: Sequence[RawTable], streams: Sequence[Stream], used: Sequence[Stream], entries: Sequence[TableMap]
) -> list[FileFault]:
    """A fault for every file without a column that is used, and for every table that is in no run."""
    files = {entry.file for entry in entries if uses(entry)}
    idle = [file for file in dict.fromkeys(table.file for table in tables) if file not in files]
    labels = {label for stream in used for label in (stream.label, *stream.parts)}
    hint = "name its columns in a map, if it should"
    faults = [FileFault(file, "no column of this file is used: it adds nothing to the record", hint) for file in idle]
    hint = "give clock_offset_s in the map if it is of the same time"
    return faults + [
        FileFault(s.label, "its times are those of no run: it adds nothing to a record", hint)
        for s in streams
        if s.label not in labels
    ]


def read_all(paths: Sequence[str | os.PathLike[str]]) -> list[RawTable]:
    """The tables of all files; what is wrong with files is told of all at once."""
    tables, faults = [], []
    if len({Path(path).resolve() for path in paths}) < len(paths):
        raise BadInput("a file is given twice", hint="give every file once")
    names = Counter(Path(path).name for path in paths)
    for path in paths:
        try:
            found = read_raw(path)
            several = names[Path(path).name] > 1
            tables += [replace(table, file=str(path)) for table in found] if several else found
        except BadInput as error:
            faults.append(
                FileFault(str(error.file or path), error.message, error.hint or "", error.row, error.column, True)
            )
    refuse_fatal(faults)
    if not tables:
        raise BadInput("no file to import", hint="give one log or more")
    return tables


def _options(mapping: Mapping | None, given: ImportOptions, answers: Dict[str, str]) -> ImportOptions:
    """The options, those of the mapping where the user says nothing, and what was answered."""
    variation = given.variation_deg
    if variation is None and VARIATION in answers:
        variation = float(answers[VARIATION])
    if mapping is not None:
        variation = mapping.magnetic_variation_deg if variation is None else variation
        side = given.positive_rudder or mapping.positive_rudder
        given = ImportOptions(given.vessel or mapping.vessel, side, given.step_s or mapping.step_s)
    side = given.positive_rudder or answers.get(RUDDER_SIDE)
    return replace(given, positive_rudder=side if is_side(side) else None, variation_deg=variation)


# ------------------------------------------------------------------------------------------------ columns


def _draft(tables: Sequence[RawTable], mapping: Mapping | None, log: RawLog, answers: Dict[str, str]) -> Drafted:
    """A row a column, the questions, and a map with all of it."""
    rows = [row for table in tables for row in _rows(table, log)]
    used = {f.table.label for f in log.findings if f.may_be}
    timed = [time.question for time in log.times.values() if time.question is not None and time.question.table in used]
    questions = [*timed, *log.proposals, *(question for f in _first(log, answers) for question in f.questions)]
    faults = [_mismatch(table, mapping) for table in tables if mapping and entry_of(table, mapping) is None]
    entries = tuple(_entry(table, mapping, log) for table in tables if table.label in used)
    idle = [table for table in tables if table.label not in used and not faults and _in_map(table, entries)]
    entries += tuple(_entry(table, mapping, log) for table in idle)
    if entries and mapping:  # the map of a log need not name its tables without a column that is used
        labels = {entry.label for entry in mapping.tables}
        faults = [fault for fault in faults if fault.fatal or fault.table in labels]
    if not faults and steering.lacks_turning(tables, log):
        said = "no column is a heading, a yaw rate or a position, or could be one: nothing tells how the ship turns"
        faults.append(FileFault(tables[0].label, said, "give the log of the gyro or of the GPS", fatal=True))
    faults += [fault for f in log.findings if (fault := _against_velocity(log, f)) is not None]
    questions += steering.questions(tables, log, mapping, answers) if not faults else []
    questions = asked_once(tables, questions)
    if faults and not entries:
        faults = [replace(fault, fatal=True) for fault in faults]
    made = (mapping or Mapping(tables=entries)) if entries else None
    if made is not None:
        said = {"rows_of": answers.get(vessels.VESSEL), "scale": answers.get(scales.SCALE)}
        said["rudder"] = steering.NONE if answers.get(steering.RUDDER) == steering.NONE else None
        known = {key: value for key, value in said.items() if value is not None}
        made = made.model_copy(update={"tables": entries, **known})
    return Drafted(_with_questions(rows, questions), tuple(questions), made, tuple(faults))


def _against_velocity(log: RawLog, found: ColumnFinding) -> FileFault | None:
    """Why a heading whose way was answered or mapped cannot go with velocities to north and east."""
    if found.quantity != "heading" or not found.signed or "sign" not in found.bounded or found.questions:
        return None
    name = signs_told.turns_against(log, found)
    hint = "are north and east exchanged? exchange the two columns in the map, or turn the heading"
    said = f"the heading turns against {name}"
    return FileFault(found.table.label, said, hint, column=found.column.name, fatal=True) if name else None


def _first(log: RawLog, answers: Dict[str, str]) -> Iterator[ColumnFinding]:
    """The findings without those of headings and sways whose way the track tells once its own axes are answered, and
    without columns that have no names, which their motion tells once their time is answered."""
    untimed = {label for label, time in log.times.items() if time.question is not None and not time.columns}
    untimed -= {label for label in untimed if proposal.question_of(label) in answers}
    tracks = {f.table.label for f in log.findings if f.questions and set(f.may_be) == {"north", "east"}}
    for found in log.findings:
        if found.table.label in untimed and found.why == WITHOUT_NAME:
            continue
        waits = found.table.label in tracks and found.quantity in ("heading", "sway")
        if not (waits and all(question.about == "sign" for question in found.questions)):
            yield found


def _in_map(table: RawTable, entries: Sequence[TableMap]) -> bool:
    """Whether a map names a table of which no column is used: a whole file, or one that the entry of another fits."""
    whole = all(entry.file != table.file for entry in entries)
    return bool(entries) and (whole or not all(missing(table, entry) for entry in entries))


def _with_questions(rows: Sequence[DraftColumn], questions: Sequence[Question]) -> tuple[DraftColumn, ...]:
    """The rows, each with the questions that stand at it."""
    return tuple(
        replace(row, questions=tuple(q for q in questions if (q.table, q.column) == (row.table, row.column)))
        for row in rows
    )


def _mismatch(table: RawTable, mapping: Mapping) -> FileFault:
    """Why no entry of a map is that of a table."""
    near = min(mapping.tables, key=lambda entry: len(missing(table, entry)))
    said = f"the mapping needs column {missing(table, near)[0]!r}, which this table lacks"
    has = ", ".join(column.name for column in table.columns)
    return FileFault(table.label, said, f"it has {has}", fatal=not table.sheet)


def _entry(table: RawTable, mapping: Mapping | None, log: RawLog) -> TableMap:
    """The entry of a table in a map: every column of it."""
    given, time = entry_of(table, mapping), log.times[table.label]
    offset = given.clock_offset_s if given is not None else None
    return TableMap(
        file=table.file,
        sheet=table.sheet,
        time=time.map(),
        clock_offset_s=time.offset_s if offset is None else offset,
        columns=tuple(_column_map(f) for f in log.findings if f.table is table),
    )


def _column_map(found: ColumnFinding) -> ColumnMap:
    if not found.may_be:
        return ColumnMap(column=found.column.name, to=NOT_USED)
    if found.quantity is None or any(question.about == "quantity" for question in found.questions):
        return ColumnMap(column=found.column.name, to="?")
    asked = {question.about for question in found.questions}
    return ColumnMap(
        column=found.column.name,
        to=found.quantity,
        unit="?" if found.unit is None or "unit" in asked else found.unit.name,
        sign="?" if not found.signed else -1 if found.sign < 0 else 1,
        factor=found.factor,
        offset=found.offset,
    )


def _opened(mapping: Mapping | None, time: bool) -> Mapping | None:
    """The map of a draft with '?' at all columns, and at the times unless they are kept: they depend on an answer."""
    if mapping is None:
        return None
    tables = []
    for entry in mapping.tables:
        columns = tuple(ColumnMap(column=column.column, to="?") for column in entry.columns)
        opened = {"time": entry.time if time else TimeMap(form="?"), "columns": columns, "clock_offset_s": None}
        tables.append(entry.model_copy(update=opened))
    return mapping.model_copy(update={"tables": tuple(tables)})


def _rows(table: RawTable, log: RawLog) -> list[DraftColumn]:
    time = log.times[table.label]
    own = {f.column.name: f for f in log.findings if f.table is table}
    return [
        _row(own[column.name]) if column.name in own else _time_row(table, column, time) for column in table.columns
    ]


def _time_row(table: RawTable, column: RawColumn, time: TableTime) -> DraftColumn:
    asked = (time.question,) if time.question is not None else ()
    why = time.why if time.zoned else f"{time.why}; the zone is not stated"
    place = table.label, column.name
    return DraftColumn(*place, TIME, time.form or "", "", why, time.sure, asked, *_span(column), column.first())


def _span(column: RawColumn) -> tuple[float, float]:
    """Smallest and largest number; nan where there is none."""
    known = column.finite
    return (float(known.min()), float(known.max())) if known.size else (float("nan"), float("nan"))


def _row(found: ColumnFinding) -> DraftColumn:
    column = found.column
    quantity = found.may_be[0] if 0 < len(found.may_be) < len(quantities()) else NOT_USED
    unit = found.unit.name if found.unit is not None else column.unit if not found.may_be else ""
    unit = f"{found.factor:g} {unit}" if found.factor != 1.0 else unit
    return DraftColumn(
        found.table.label, column.name, quantity, unit, found.convention, "; ".join(dict.fromkeys(found.why)),
        found.sure, found.questions, *_span(column), column.first(),
    )  # fmt: skip


# ------------------------------------------------------------------------------------------------ runs


def runs(streams: Sequence[Stream]) -> list[tuple[str, list[Stream]]]:
    """Streams sorted into runs: those with the same quantities are different runs, unless one goes on with another."""
    streams = _joined(streams)
    counts = Counter(frozenset(stream.quantities) for stream in streams)
    heads = _heads(streams)
    if max(counts.values()) == 1:
        return [(Path(heads[0].label.split(" [")[0]).stem, list(streams))]
    if len(counts) == 1:
        return [(_run_name(stream), [stream]) for stream in streams]
    return [(_run_name(head), [head, *_overlapping(head, [s for s in streams if s not in heads])]) for head in heads]


def _heads(streams: Sequence[Stream]) -> list[Stream]:
    """The streams that runs are named by: of the rudder, where there is none of what else leads."""
    kinds = ({"rudder", "rudder_command"}, {"thrust_port"}, {"heading", "heading_magnetic", "yaw_rate"}, LED_BY_TRACK)
    heads = ([s for s in streams if kind & s.quantities.keys()] for kind in kinds)
    return next((found for found in heads if found), list(streams))


def _run_name(stream: Stream) -> str:
    number = f"-run{stream.run}" if stream.run else ""
    file, _, sheet = stream.table.partition(" [")
    stem, sheet = Path(file).stem, sheet.rstrip("]").replace(" ", "_").replace("/", "_")
    return f"{stem}-{sheet}{number}" if sheet else f"{stem}{number}"


def _overlapping(head: Stream, others: Sequence[Stream]) -> list[Stream]:
    dated = [s for s in others if s.dated and s.time[-1] > head.time[0] and s.time[0] < head.time[-1]]
    return dated + [s for s in others if not (s.dated and head.dated) and s.run and s.run == head.run]


def _joined(streams: Sequence[Stream]) -> list[Stream]:
    """Files of one logger that follow each other are joined."""
    out: list[Stream] = []
    for stream in sorted(streams, key=lambda s: s.time[0] if s.dated else 0.0):
        before = next((s for s in out if _goes_on(s, stream)), None)
        if before is None:
            out.append(stream)
            continue
        out[out.index(before)] = replace(
            before,
            time=np.concatenate([before.time, stream.time]),
            quantities={k: np.concatenate([v, stream.quantities[k]]) for k, v in before.quantities.items()},
            kept=np.concatenate([before.kept, stream.kept]),
            done=(*before.done, *stream.done, f"{stream.label}: goes on with {before.label}, joined"),
            parts=(*before.parts, stream.label),
        )
    return out


def _goes_on(first: Stream, second: Stream) -> bool:
    gap = second.time[0] - first.time[-1]
    same = first.quantities.keys() == second.quantities.keys() and first.dated and second.dated
    return same and 0.0 < gap < SAME_RUN * max(first.step, second.step)


def _record(
    name: str, merged: Merged, options: ImportOptions, log: RawLog
) -> tuple[Record | None, list[str], list[FileFault], list[Question], dict[str, tuple[str, ...]]]:
    """The record of a run, what was done, faults, what is asked, and the quantities of each channel."""
    made = derive(name, merged.time, merged.quantities, options.variation_deg)
    ends = merged.time[0], merged.time[-1]
    short = any(s.time[0] < ends[0] - s.step or s.time[-1] > ends[1] + s.step for s in merged.streams)
    channels, constant = _living(name, made.found, short)
    faults = [*made.faults, *constant]
    known = np.isfinite(np.array(list(channels.values()))).any(axis=0) if channels else np.zeros(0, dtype=bool)
    if known.sum() < MIN_SAMPLES:
        fault = FileFault(name, f"{int(known.sum())} samples", f"a record needs {MIN_SAMPLES}", fatal=True)
        return None, [], [*faults, fault], [], {}
    start = float(merged.time[0])
    facts = made.facts | _start(merged)
    meta = RecordMeta(vessel=options.vessel, source=", ".join(s.label for s in merged.streams), extra=facts)
    record = Record(merged.time - start, channels, name, meta)
    faults += _against_track(record)
    record, told, more, asked = _signed(record, options.positive_rudder, log)
    if "heading_magnetic" in merged.quantities and "heading" not in merged.quantities and made.variation is None:
        asked.append(_variation_question(log))
    more += [FileFault(d.record, d.message, d.hint, column=d.column, fatal=d.fatal) for d in doubts(record)]
    notes = "; ".join(map(str, [*faults, *more])) or None
    record = replace(record, meta=replace(record.meta, notes=notes))
    return record, [*merged.steps, *made.steps, *told], [*faults, *more], asked, made.sources


def _against_track(record: Record) -> list[FileFault]:
    """What the course of the positions says against the heading: other axes and directions of rotation show there."""
    track = track_of(record)
    if track is not None and track.mirrored:
        hint = f"as if {track.reading}; or give the heading sign -1 in the mapping: mathematical angles count from east"
        return [FileFault(record.name, "the heading turns against the track", hint, column="heading", fatal=True)]
    if track is None or abs(track.angle) < ASKEW_RAD:
        return []
    said = f"the ship moves {math.degrees(track.angle):+.0f} deg from its heading on average"
    return [FileFault(record.name, said, "check the zero of the heading, and which of north and east is which")]


def _start(merged: Merged) -> dict[str, str]:
    """The first time of a run with a date: in UTC where the file states that its times are."""
    if not merged.dated:
        return {}
    stamp = datetime.datetime.fromtimestamp(float(merged.time[0]), datetime.UTC).isoformat(timespec="milliseconds")
    zoned = any(stream.zoned for stream in merged.streams if stream.dated)
    return {"start_utc": stamp} if zoned else {"start_of_unknown_zone": stamp.removesuffix("+00:00")}


def _variation_question(log: RawLog) -> Question:
    text = "The heading is magnetic and no variation is known: how many degrees to east is it?"
    answers = (Answer("0", "0: use it as true heading", "magnetic_variation_deg: 0"),)
    number = "degrees to east: magnetic_variation_deg: NUMBER"
    return Question(VARIATION, "quantity", *_place(log, "heading_magnetic"), text, answers, number)


def _place(log: RawLog, *wanted: str) -> tuple[str, str]:
    """Table and column of the first of some quantities."""
    found = next(f for name in wanted for f in log.findings if f.quantity == name)
    return found.table.label, found.column.name


def _living(name: str, found: dict[str, np.ndarray], short: bool) -> tuple[dict[str, np.ndarray], list[FileFault]]:
    """Channels without those that never change or have no value, dead sensors; a rudder may be held, which is told.

    short : whether tables go on before or after the record, where a channel may change.
    """
    kept, faults = {}, []
    why = "a dead sensor, or too short a time that all tables cover?" if short else "a dead sensor?"
    for channel, values in found.items():
        known = values[np.isfinite(values)]
        dead = known.size == 0 or (np.ptp(known) == 0.0 and channel not in MAY_BE_CONSTANT)
        said = f"{known[0]:.4g} in every row" if known.size else "no value"
        if dead and channel not in RUDDERS:
            faults.append(FileFault(name, said, f"{why} the channel is left out", column=channel))
            continue
        if dead:
            faults.append(FileFault(name, said, "was the rudder held, or is its sensor dead?", column=channel))
        kept[channel] = values
    return kept, faults


def _signed(
    record: Record, given: Side | None, log: RawLog
) -> tuple[Record, list[str], list[FileFault], list[Question]]:
    """The record with the side of its positive rudder: as given, as the file states it, or told by the yaw response."""
    if not any(map(record.has, RUDDERS)):
        return record, [f"{record.name}: there is no rudder in this log; sensors can be checked"], [], []
    if given is not None:
        record = replace(record, meta=replace(record.meta, positive_rudder=given))
        doubt = rudder_sign_doubt(record)
        hint = "check --positive-rudder, or the signs of rudder and heading"
        said = f"the ship turns against a rudder that is positive to {given}"
        return record, [], [FileFault(record.name, said, hint)] if doubt else [], []
    stated = stated_side(log)
    told = steering_side(record)
    if record.has(*TWIN):
        return (record, *_twin(record, told), [])
    if stated and (told is None or told[0] == stated):
        record = replace(record, meta=replace(record.meta, positive_rudder=stated))
        return record, [f"{record.name}: positive rudder to {stated}, as the file states"], [], []
    if told is not None and not stated:
        record = replace(record, meta=replace(record.meta, positive_rudder=told[0]))
        said = f"{record.name}: positive rudder turns the ship to {told[0]} (confidence {told[1]:.0%})"
        return record, [said], [], []
    known = record.rudder()[np.isfinite(record.rudder())]
    if not known.size or np.ptp(known) == 0.0:
        hint = "give --positive-rudder port or starboard"
        return record, [], [FileFault(record.name, "the yaw response does not tell the rudder's sign", hint)], []
    why = f"The file says to {stated}, and the yaw response the other side." if stated else ""
    text = f"To which side does a positive rudder turn the ship? {why or 'The yaw response does not tell.'}"
    sides = sorted(("starboard", "port"), key=lambda side: side != (told[0] if told else "starboard"))
    answers = tuple(Answer(side, f"to {side}", f"positive_rudder: {side}") for side in sides)
    place = _place(log, "rudder", "rudder_command")
    return record, [], [], [Question(RUDDER_SIDE, "rudder side", *place, text, answers)]


def _twin(record: Record, told: tuple[Side, float] | None) -> tuple[list[str], list[FileFault]]:
    """What the yaw response says of two propellers that steer."""
    if told is None:
        return [f"{record.name}: the yaw response does not tell which propeller is to port; as named or answered"], []
    if told[0] == "starboard":
        return [f"{record.name}: more thrust to port turns the ship to {told[0]} (confidence {told[1]:.0%})"], []
    hint = "port and starboard exchanged? exchange the two columns in the mapping"
    return [], [FileFault(record.name, "the ship turns against its two propellers", hint, column=TWIN[0])]


def _aside(merged: Merged, streams: Sequence[Stream], tables: Sequence[RawTable], used: Sequence[TableMap]) -> Aside:
    """Columns of the run's tables that are no channel, over the record's time; not where the time alone is left."""
    out: Aside = {}
    own = {table.label: table for table in tables}
    channels = {c.column for table in used for c in table.columns if c.to != NOT_USED}
    times = {name for table in used for name in table.time.columns}
    for run in merged.streams:
        for stream in (s for s in streams if s.label in (run.label, *run.parts)):
            rest = [column for column in own[stream.table].columns if column.name not in channels]
            if any(column.name not in times for column in rest):
                time = run.on_clock(stream.time) - merged.time[0]
                out[stream.label] = {"time_s": time, **{c.name: c.at(stream.kept) for c in rest}}
    for table in (own[stream.table] for stream in streams):
        if table.faults:
            lines, wrong, texts = map(list, zip(*table.faults, strict=True))
            out[f"{table.label}, lines left out"] = {"line": lines, "what is wrong": wrong, "text": texts}
    return out
