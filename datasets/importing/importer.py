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
from ..yaw_response import rudder_sign_doubt, steering_side
from . import choices, proposal, steering
from .clock import FORMS, seconds, spread
from .clocks import on_dates
from .convert import Channels, Stream, derive, streams_of
from .draft import NOT_USED, TIME, Answer, DraftColumn, Question, asked_once
from .evidence import sense
from .finding import AS_RECORD, WITH_SIDE, ColumnFinding
from .guess import entry_of, examine, missing
from .log import RawLog
from .mapping import ColumnMap, Mapping, TableMap, TimeMap, uses
from .merge import Merged, merge
from .other_channels import NO_NUMBERS
from .quantities import quantities
from .raw import RawTable
from .reading import WITHOUT_NAME
from .result import Aside, FileFault, Import, ImportFault, ImportReport, channel_sources, refuse_fatal
from .sources import read_raw

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
    tables, vessel = choices.of_one_vessel(tables, mapping, answers)
    if vessel is not None:
        return tables, [vessel]
    tables, scale = choices.of_one_scale(tables, mapping, answers)
    return tables, [scale] if scale is not None else []


def _imported(
    tables: Sequence[RawTable], mapping: Mapping | None, options: ImportOptions, answers: Dict[str, str]
) -> tuple[Drafted, Import]:
    tables, chosen = chosen_parts(tables, mapping, answers)
    log = examine(tables, mapping, answers)
    drafted = _draft(tables, mapping, log, answers)
    if chosen:  # what else is asked depends on the answer
        drafted = replace(drafted, columns=_with_questions(drafted.columns, chosen), questions=tuple(chosen))
        drafted = replace(drafted, mapping=_opened(drafted.mapping, time=chosen[0].id == choices.VESSEL))
    rows, draft = drafted.columns, drafted.mapping
    faults = list(drafted.faults)
    said = _options(mapping, options, answers)
    streams: list[Stream] = []
    used = draft.tables if draft is not None else ()
    for table in tables:
        entry = next((e for e in used if e.label == table.label), None)
        if entry is not None and entry.time.form != "?" and uses(entry):
            own, found = streams_of(table, entry, log.times[table.label])
            faults += found
            streams += own
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
        record, made = _record(name, merged, said, log)
        faults += made.faults
        questions += made.questions
        if record is not None:
            steps += [*merged.steps, *made.steps]
            records.append(record)
            parts = {label for stream in merged.streams for label in (stream.label, *stream.parts)}
            own = [row for row in rows if row.table in parts]
            sources += channel_sources(name, list(record.channels), made.sources, own)
        aside |= _aside(merged, streams, tables, used)
    sides = {record.meta.positive_rudder for record in records} - {None}
    if len(sides) == 1 and any(stream.run for stream in streams):  # some of the runs tell it for all
        records = [replace(r, meta=replace(r.meta, positive_rudder=next(iter(sides)))) for r in records]
        questions = [question for question in questions if question.id != RUDDER_SIDE]
    asked = tuple(dict.fromkeys(questions))
    refuse_fatal(faults, _with_questions(rows, asked) if asked else rows, draft, asked)
    side = next((r.meta.positive_rudder for r in records), None)
    facts = {"vessel": said.vessel, "step_s": said.step_s, "magnetic_variation_deg": said.variation_deg}
    assert draft is not None
    draft = draft.model_copy(update={"positive_rudder": said.positive_rudder or side, **facts})
    rows = tuple(replace(r, sign=f"positive to {side}") if side and r.sign == AS_RECORD else r for r in rows)
    report = ImportReport(rows, tuple(steps), tuple(faults), tuple(sources))
    drafted = replace(drafted, columns=rows, mapping=draft, faults=tuple(faults))
    return drafted, Import(tuple(records), draft, report, aside)


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
    variation, side = given.variation_deg, given.positive_rudder
    if variation is None and VARIATION in answers:
        variation = float(answers[VARIATION])
    if mapping is not None:
        variation = mapping.magnetic_variation_deg if variation is None else variation
        side = side or mapping.positive_rudder
        given = replace(given, vessel=given.vessel or mapping.vessel, step_s=given.step_s or mapping.step_s)
    side = side or answers.get(RUDDER_SIDE)
    return replace(given, positive_rudder=side if is_side(side) else None, variation_deg=variation)


def _draft(tables: Sequence[RawTable], mapping: Mapping | None, log: RawLog, answers: Dict[str, str]) -> Drafted:
    """A row a column, the questions, and a map with all of it."""
    rows = [row for table in tables for row in _rows(table, log)]
    used = {f.table.label for f in log.findings if f.may_be}
    timed = [time.question for time in log.times.values() if time.question is not None and time.question.table in used]
    questions = [*timed, *log.proposals, *(question for f in _first(log, answers) for question in f.questions)]
    faults = []
    for table in tables:
        if mapping and entry_of(table, mapping) is None:
            near = min(mapping.tables, key=lambda entry: len(missing(table, entry)))
            said = f"the mapping needs column {missing(table, near)[0]!r}, which this table lacks"
            has = ", ".join(column.name for column in table.columns)
            faults.append(FileFault(table.label, said, f"it has {has}", fatal=not table.sheet))
    entries = tuple(_entry(table, mapping, log) for table in tables if table.label in used)
    if entries and not faults:  # of tables without a column that is used a whole file, or one whose entry fits another
        rest = [table for table in tables if table.label not in used]
        files = {entry.file for entry in entries}
        idle = [t for t in rest if t.file not in files or not all(missing(t, entry) for entry in entries)]
        entries += tuple(_entry(table, mapping, log) for table in idle)
    if entries and mapping:  # the map of a log need not name its tables without a column that is used
        labels = {entry.label for entry in mapping.tables}
        faults = [fault for fault in faults if fault.fatal or fault.table in labels]
    steering_asked = steering.questions(tables, log, mapping, answers) if not faults else []
    if steering_asked is None:
        said = "no column is a heading, a yaw rate or a position, or could be one: nothing tells how the ship turns"
        faults.append(FileFault(tables[0].label, said, "give the log of the gyro or of the GPS", fatal=True))
    faults += [fault for f in log.findings if (fault := _against_velocity(log, f)) is not None]
    unread = [f for f in log.findings if f.why == NO_NUMBERS and steering.is_called_rudder(f)]
    if steering.is_unsteered({quantity for f in log.findings for quantity in f.may_be}):
        hint = "write them as numbers; or leave the column out in a map, where there is to be no rudder"
        texts = [(f, f"no number: {f.column.first(1)[0]!r}") for f in unread]
        faults += [FileFault(f.table.label, text, hint, None, f.column.name, True) for f, text in texts]
    questions = asked_once(tables, [*questions, *(steering_asked or ())] if not faults else questions)
    if faults and not entries:
        faults = [replace(fault, fatal=True) for fault in faults]
    made = (mapping or Mapping(tables=entries)) if entries else None
    if made is not None:
        said = {"rows_of": answers.get(choices.VESSEL), "scale": answers.get(choices.SCALE)}
        said["rudder"] = steering.NONE if answers.get(steering.RUDDER) == steering.NONE else None
        known = {key: value for key, value in said.items() if value is not None}
        made = made.model_copy(update={"tables": entries, **known})
    return Drafted(_with_questions(rows, questions), tuple(questions), made, tuple(faults))


def _against_velocity(log: RawLog, found: ColumnFinding) -> FileFault | None:
    """Why a heading whose way was answered or mapped cannot go with velocities to north and east."""
    decided = found.quantity == "heading" and found.signed and "sign" in found.bounded and not found.questions
    series = log.series(found) if decided else None
    hint = "are north and east exchanged? exchange the two columns in the map, or turn the heading"
    for first, north in log.all("velocity_north") if series is not None else ():
        for second, east in log.all("velocity_east"):
            told = sense(series, north, east) if first.table is second.table and series is not None else None
            if told is not None and told[0] == "against":
                said = f"the heading turns against {first.column.name}, {second.column.name}"
                return FileFault(found.table.label, said, hint, column=found.column.name, fatal=True)
    return None


def _first(log: RawLog, answers: Dict[str, str]) -> Iterator[ColumnFinding]:
    """The findings without those of headings, yaw rates and sways whose way the track tells once its own axes are
    answered, and without columns that have no names, which their motion tells once their time is answered."""
    untimed = {label for label, time in log.times.items() if time.question is not None and not time.columns}
    untimed -= {label for label in untimed if proposal.columns_question(label) in answers}
    tracks = {f.table.label for f in log.findings if f.questions and set(f.may_be) == {"north", "east"}}
    for found in log.findings:
        if found.table.label in untimed and found.why == WITHOUT_NAME:
            continue
        waits = found.table.label in tracks and found.quantity in ("heading", "yaw_rate", "sway")
        if not (waits and all(question.about == "sign" for question in found.questions)):
            yield found


def _with_questions(rows: Sequence[DraftColumn], questions: Sequence[Question]) -> tuple[DraftColumn, ...]:
    """The rows, each with the questions that stand at it."""
    return tuple(
        replace(row, questions=tuple(q for q in questions if (q.table, q.column) == (row.table, row.column)))
        for row in rows
    )


def _entry(table: RawTable, mapping: Mapping | None, log: RawLog) -> TableMap:
    """The entry of a table in a map: every column of it."""
    given, time, columns = entry_of(table, mapping), log.times[table.label], []
    for found in (f for f in log.findings if f.table is table):
        asked = {question.about for question in found.questions}
        if not found.may_be or found.quantity is None or found.waits or "quantity" in asked:
            columns.append(ColumnMap(column=found.column.name, to="?" if found.may_be or found.waits else NOT_USED))
            continue
        unit = "?" if found.unit is None or "unit" in asked else found.unit.name
        columns.append(ColumnMap(
            column=found.column.name, to=found.quantity, unit=unit, factor=found.factor, offset=found.offset,
            sign="?" if not found.signed else -1 if found.sign < 0 else 1,
        ))  # fmt: skip
    offset = given.clock_offset_s if given is not None else None
    return TableMap(
        file=table.file,
        sheet=table.sheet,
        time=TimeMap(columns=time.columns, form=time.form or "?", step_s=time.step_s),
        clock_offset_s=time.offset_s if offset is None else offset,
        columns=tuple(columns),
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


def _rows(table: RawTable, log: RawLog) -> Iterator[DraftColumn]:
    """A row for every column of a table: the time, or what it was taken for."""
    time, findings = log.times[table.label], {f.column.name: f for f in log.findings if f.table is table}
    for column in table.columns:
        found, known = findings.get(column.name), column.finite
        if found is None:
            why = time.why if time.zoned else f"{time.why}; the zone is not stated"
            asked = (time.question,) if time.question is not None else ()
            facts = TIME, time.form or "", "", why, time.sure, asked
        else:
            quantity = found.may_be[0] if 0 < len(found.may_be) < len(quantities()) else NOT_USED
            unit = found.unit.name if found.unit is not None else column.unit if not found.may_be else ""
            unit = f"{found.factor:g} {unit}" if found.factor != 1.0 else unit
            why = "; ".join(dict.fromkeys(found.why))
            facts = quantity, unit, found.convention, why, found.sure, found.questions
        span = (float(known.min()), float(known.max())) if known.size else (math.nan, math.nan)
        yield DraftColumn(table.label, column.name, *facts, *span, column.first())


def runs(streams: Sequence[Stream]) -> list[tuple[str, list[Stream]]]:
    """Streams sorted into runs: those with the same quantities are different runs, unless one goes on with another.

    Runs are named by the streams of the rudder, or where there is none of what else leads.
    """
    streams = _joined(streams)
    counts = Counter(frozenset(stream.quantities) for stream in streams)
    kinds = ({"rudder", "rudder_command"}, {"thrust_port"}, {"heading", "heading_magnetic", "yaw_rate"}, LED_BY_TRACK)
    leading = ([s for s in streams if kind & s.quantities.keys()] for kind in kinds)
    heads = next((found for found in leading if found), streams)
    if max(counts.values()) == 1:
        return [(Path(heads[0].label.split(" [")[0]).stem, list(streams))]
    if len(counts) == 1:
        return [(_run_name(stream), [stream]) for stream in streams]
    out, others = [], [stream for stream in streams if stream not in heads]
    for head in heads:
        dated = [s for s in others if s.dated and s.time[-1] > head.time[0] and s.time[0] < head.time[-1]]
        same = [s for s in others if not (s.dated and head.dated) and s.run and s.run == head.run]
        out.append((_run_name(head), [head, *dated, *same]))
    return out


def _run_name(stream: Stream) -> str:
    number = f"-run{stream.run}" if stream.run else ""
    file, _, sheet = stream.table.partition(" [")
    stem, sheet = Path(file).stem, sheet.rstrip("]").replace(" ", "_").replace("/", "_")
    return f"{stem}-{sheet}{number}" if sheet else f"{stem}{number}"


def _joined(streams: Sequence[Stream]) -> list[Stream]:
    """Files of one logger that follow each other are joined."""
    out: list[Stream] = []
    for stream in sorted(streams, key=lambda s: s.time[0] if s.dated else 0.0):
        same = (s for s in out if s.quantities.keys() == stream.quantities.keys() and s.dated and stream.dated)
        gaps = ((s, stream.time[0] - s.time[-1], SAME_RUN * max(s.step, stream.step)) for s in same)
        before = next((s for s, gap, longest in gaps if 0.0 < gap < longest), None)
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


def _record(name: str, merged: Merged, options: ImportOptions, log: RawLog) -> tuple[Record | None, Channels]:
    """The record of a run, None where it is too short; its channels with what was done, faults, and what is asked."""
    made = derive(name, merged.time, merged.quantities, options.variation_deg)
    ends = merged.time[0], merged.time[-1]
    channels = _living(made, any(s.time[0] < ends[0] - s.step or s.time[-1] > ends[1] + s.step for s in merged.streams))
    known = np.isfinite(np.array(list(channels.values()))).any(axis=0) if channels else np.zeros(0, dtype=bool)
    if known.sum() < MIN_SAMPLES:
        few = f"{int(known.sum())} samples"
        made.faults.append(FileFault(name, few, f"a record needs {MIN_SAMPLES}", fatal=True))
        return None, made
    start, facts = float(merged.time[0]), made.facts
    if merged.dated:  # in UTC where a file states that its times are
        stamp = datetime.datetime.fromtimestamp(start, datetime.UTC).isoformat(timespec="milliseconds")
        zoned = any(stream.zoned for stream in merged.streams if stream.dated)
        facts |= {"start_utc": stamp} if zoned else {"start_of_unknown_zone": stamp.removesuffix("+00:00")}
    meta = RecordMeta(vessel=options.vessel, source=", ".join(s.label for s in merged.streams), extra=facts)
    record = Record(merged.time - start, channels, name, meta)
    track = track_of(record)  # other axes and directions of rotation show in the course of the positions
    if track is not None and track.mirrored:
        hint = f"as if {track.reading}; or give the heading sign -1 in the mapping: mathematical angles count from east"
        made.faults.append(FileFault(name, "the heading turns against the track", hint, column="heading", fatal=True))
    elif track is not None and abs(track.angle) >= ASKEW_RAD:
        said = f"the ship moves {math.degrees(track.angle):+.0f} deg from its heading on average"
        made.warn(said, "check the zero of the heading, and which of north and east is which")
    record = _signed(record, options.positive_rudder, log, made)
    if "heading_magnetic" in merged.quantities and "heading" not in merged.quantities and made.variation is None:
        text = "The heading is magnetic and no variation is known: how many degrees to east is it?"
        answers = (Answer("0", "0: use it as true heading", "magnetic_variation_deg: 0"),)
        number = "degrees to east: magnetic_variation_deg: NUMBER"
        made.questions.append(Question(VARIATION, "quantity", *_place(log, "heading_magnetic"), text, answers, number))
    made.faults += [FileFault(d.record, d.message, d.hint, column=d.column, fatal=d.fatal) for d in doubts(record)]
    notes = "; ".join(map(str, made.faults)) or None
    return replace(record, meta=replace(record.meta, notes=notes)), made


def _place(log: RawLog, *wanted: str) -> tuple[str, str]:
    """Table and column of the first of some quantities."""
    found = next(f for name in wanted for f in log.findings if f.quantity == name)
    return found.table.label, found.column.name


def _living(made: Channels, short: bool) -> dict[str, np.ndarray]:
    """Channels without those that never change or have no value, dead sensors; a rudder may be held, which is told.

    short : whether tables go on before or after the record, where a channel may change.
    """
    kept = {}
    why = "a dead sensor, or too short a time that all tables cover?" if short else "a dead sensor?"
    for channel, values in made.found.items():
        known = values[np.isfinite(values)]
        if known.size and (np.ptp(known) > 0.0 or channel in MAY_BE_CONSTANT):
            kept[channel] = values
            continue
        said = f"{known[0]:.4g} in every row" if known.size else "no value"
        hint = f"{why} the channel is left out"
        if channel in RUDDERS:
            kept[channel], hint = values, "was the rudder held, or is its sensor dead?"
        made.faults.append(FileFault(made.label, said, hint, column=channel))
    return kept


def _signed(record: Record, given: Side | None, log: RawLog, made: Channels) -> Record:
    """The record with the side of its positive rudder: as given, as the file states it, or told by the yaw response."""
    name = record.name
    if not any(map(record.has, RUDDERS)):
        made.steps.append(f"{name}: there is no rudder in this log; sensors can be checked")
        return record
    if given is not None:
        record = replace(record, meta=replace(record.meta, positive_rudder=given))
        if rudder_sign_doubt(record):
            said = f"the ship turns against a rudder that is positive to {given}"
            made.warn(said, "check --positive-rudder, or the signs of rudder and heading")
        return record
    told = steering_side(record)
    if record.has(*TWIN):
        if told is not None and told[0] != "starboard":
            hint = "port and starboard exchanged? exchange the two columns in the mapping"
            made.faults.append(FileFault(name, "the ship turns against its two propellers", hint, column=TWIN[0]))
            return record
        said = "the yaw response does not tell which propeller is to port; as named or answered"
        if told is not None:
            said = f"more thrust to port turns the ship to {told[0]} (confidence {told[1]:.0%})"
        made.steps.append(f"{name}: {said}")
        return record
    by_file = ({f.side for f in log.findings if f.quantity == quantity and f.side} for quantity in WITH_SIDE)
    sides = next((own for own in by_file if own), set())
    stated = next(iter(sides)) if len(sides) == 1 else ""
    if is_side(stated) and (told is None or told[0] == stated):
        made.steps.append(f"{name}: positive rudder to {stated}, as the file states")
        return replace(record, meta=replace(record.meta, positive_rudder=stated))
    if told is not None and not stated:
        made.steps.append(f"{name}: positive rudder turns the ship to {told[0]} (confidence {told[1]:.0%})")
        return replace(record, meta=replace(record.meta, positive_rudder=told[0]))
    known = record.rudder()[np.isfinite(record.rudder())]
    if not known.size or np.ptp(known) == 0.0:
        made.warn("the yaw response does not tell the rudder's sign", "give --positive-rudder port or starboard")
        return record
    why = f"The file says to {stated}, and the yaw response the other side." if stated else ""
    text = f"To which side does a positive rudder turn the ship? {why or 'The yaw response does not tell.'}"
    likely = sorted(("starboard", "port"), key=lambda side: side != (told[0] if told else "starboard"))
    answers = tuple(Answer(side, f"to {side}", f"positive_rudder: {side}") for side in likely)
    place = _place(log, "rudder", "rudder_command")
    made.questions.append(Question(RUDDER_SIDE, "rudder side", *place, text, answers))
    return record


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
