"""The chain of an import: raw tables, mapping, quantities, one time base, records."""

from __future__ import annotations

import datetime
import os
from collections import Counter
from collections.abc import Mapping as Dict
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, TypeAlias

import numpy as np

from ...models.errors import BadInput
from ..columns import RUDDERS
from ..io import MAY_BE_CONSTANT, MIN_SAMPLES
from ..plausibility import doubts
from ..record import Record, RecordMeta, Side
from ..rudder_sign import rudder_sign_doubt, steering_side
from .clock import FORMS, seconds, spread
from .convert import Stream, stream_of
from .derive import derive
from .draft import NOT_USED, DraftColumn, Sure
from .guess import SURE, ColumnGuess, TableGuess, guess_table
from .mapping import Mapping, TableMap
from .merge import Merged, merge
from .raw import RawColumn, RawTable
from .report import Fault, ImportReport, refuse_fatal, span
from .sources import read_raw

Aside: TypeAlias = "dict[str, dict[str, Any]]"
"""Table -> column -> samples (N,) that are no channel, with the record's `time_s` first."""
MAP_HINT = "name it in a mapping (--map), with its unit"
SAME_RUN = 5.0
"""Steps after its end within which another file of the same columns goes on with a run."""


@dataclass(frozen=True)
class Options:
    """What the user says besides the mapping; None: told by the log or left open."""

    vessel: str | None = None
    positive_rudder: Side | None = None
    step_s: float | None = None
    variation_deg: float | None = None


@dataclass(frozen=True)
class Imported:
    """Records of a log, the mapping that made them, the report, and columns that are kept aside."""

    records: tuple[Record, ...]
    mapping: Mapping
    report: ImportReport
    aside: Aside


@dataclass(frozen=True)
class Drafted:
    """What the columns of a log are taken for; `mapping` the same as a file, with what is open as '?'."""

    columns: tuple[DraftColumn, ...]
    mapping: Mapping | None
    faults: tuple[Fault, ...]


def draft_tables(tables: Sequence[RawTable], mapping: Mapping | None, answers: Dict[str, str]) -> Drafted:
    """What every column of a log is taken for, and the questions that are open.

    Parameters
    ----------
    tables : of all files.
    mapping : what the columns are; None: told by the log.
    answers : id of a question -> key of its answer.
    """
    guesses = [guess_table(table) for table in tables]
    _, rows, faults = _matched(tables, mapping) if mapping else _guessed(guesses)
    return Drafted(tuple(rows), mapping or _draft(guesses), tuple(faults))


def raw_series(tables: Sequence[RawTable], drafted: Drafted, label: str, name: str) -> tuple[np.ndarray, np.ndarray]:
    """Times (N,), s, or row numbers where no time is known, and the numbers (N,) of a column; BadInput for no such."""
    table = next((table for table in tables if table.label == label), None)
    column = table.column(name) if table is not None else None
    if table is None or column is None:
        raise BadInput(f"no column {name!r} in {label!r}")
    times = [row.column for row in drafted.columns if row.table == label and row.quantity == "time"]
    form = next((row.unit for row in drafted.columns if row.table == label and row.quantity == "time"), None)
    if form not in FORMS:
        return np.arange(table.n, dtype=float), column.numbers
    return spread(seconds([c for n in times if (c := table.column(n))], form))[0], column.numbers


def import_tables(
    tables: Sequence[RawTable], mapping: Mapping | None, options: Options, answers: Dict[str, str]
) -> Imported:
    """Import logs as records.

    Parameters
    ----------
    tables : of one logger or several, of one run or several.
    mapping : what the columns are; None: told by the log.
    answers : id of a question -> key of its answer.

    Raises
    ------
    ImportFault : whatever keeps the logs from being records, all faults at once.
    """
    guesses = [] if mapping else [guess_table(table) for table in tables]
    draft = _draft(guesses)
    pairs, rows, faults = _matched(tables, mapping) if mapping else _guessed(guesses)
    refuse_fatal(faults, rows, draft)
    merged_options = _options(mapping, options)
    streams: list[tuple[Stream, RawTable]] = []
    for table, entry in pairs:
        stream, found = stream_of(table, entry)
        faults += found
        streams += [(stream, table)] if stream is not None else []
    if not any({"rudder", "rudder_command"} & s.quantities.keys() for s, _ in streams):
        faults = _without_rudder(tables, faults)
    refuse_fatal(faults, rows, draft)
    used = mapping or Mapping(tables=tuple(entry for _, entry in pairs))
    steps = [f"{table.label}: {', '.join(table.done)}" for table in tables if table.done]
    records, aside = [], {}
    for name, run in runs([stream for stream, _ in streams]):
        merged, found = merge(run, merged_options.step_s)
        faults += found
        if merged is None:
            continue
        record, done, found = _record(name, merged, merged_options)
        steps += done
        faults += found
        records += [record] if record is not None else []
        aside |= _aside(merged, streams, used)
    refuse_fatal(faults, rows, draft)
    side = next((r.meta.positive_rudder for r in records), None)
    said = merged_options
    facts = {"vessel": said.vessel, "step_s": said.step_s, "magnetic_variation_deg": said.variation_deg}
    used = used.model_copy(update={"positive_rudder": said.positive_rudder or side, **facts})
    return Imported(tuple(records), used, ImportReport(tuple(rows), tuple(steps), tuple(faults)), aside)


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
                Fault(str(error.file or path), error.message, error.hint or "", error.row, error.column, True)
            )
    refuse_fatal(faults)
    if not tables:
        raise BadInput("no file to import", hint="give one log or more")
    return tables


def _options(mapping: Mapping | None, given: Options) -> Options:
    """The options, those of the mapping where the user says nothing."""
    if mapping is None:
        return given
    return Options(
        given.vessel or mapping.vessel,
        given.positive_rudder or mapping.positive_rudder,
        given.step_s or mapping.step_s,
        mapping.magnetic_variation_deg if given.variation_deg is None else given.variation_deg,
    )


# ------------------------------------------------------------------------------------------------ columns


def _draft(guesses: Sequence[TableGuess]) -> Mapping | None:
    """A mapping with every guess however unsure, to be changed by hand."""
    entries = [entry for guess in guesses if (entry := guess.mapping(least=0.0)) is not None]
    return Mapping(tables=tuple(entries)) if entries else None


def _guessed(
    guesses: Sequence[TableGuess],
) -> tuple[list[tuple[RawTable, TableMap]], list[DraftColumn], list[Fault]]:
    """Tables with their guessed mappings, a row a column, and tables that cannot be used."""
    rows = [row for guess in guesses for row in _guess_rows(guess)]
    pairs = [(guess.table, entry) for guess in guesses if (entry := guess.mapping()) is not None]
    faults = [_unused(guess, fatal=not pairs) for guess in guesses if guess.mapping() is None]
    faults += [
        _unsure(guess.table, g) for guess in guesses for g in guess.columns if g.quantity and g.confidence < SURE
    ]
    return pairs, rows, faults


def _unused(guess: TableGuess, fatal: bool) -> Fault:
    names = ", ".join(column.name for column in guess.table.columns)
    if guess.time is None:
        hint = "name the time's column and form in a mapping (--map)"
        return Fault(guess.table.label, f"no column looks like a time; columns: {names}", hint, fatal=fatal)
    said = f"no column has a name and a unit that are known; columns: {names}"
    return Fault(guess.table.label, said, "name them in a mapping (--map)", fatal=fatal)


def _unsure(table: RawTable, guess: ColumnGuess) -> Fault:
    hint = f"kept aside; {MAP_HINT}"
    return Fault(table.label, f"{guess.quantity}? {guess.reason}", hint, column=guess.column.name)


def _guess_rows(guess: TableGuess) -> list[DraftColumn]:
    table = guess.table
    rows = []
    for name in guess.time_columns:
        column = table.column(name)
        if column is not None and guess.time is not None:
            rows.append(_row_of(table, column, "time", guess.time.form, 1, guess.time.reason, "stated"))
    for g in guess.columns:
        used = g.quantity is not None and g.unit is not None and g.confidence >= SURE
        unit = g.unit.name if g.unit is not None else g.column.unit
        to = str(g.quantity) if used else NOT_USED
        why = g.reason if used or g.quantity is None else f"{g.quantity}? {g.reason}"
        rows.append(_row_of(table, g.column, to, unit, g.sign, why, _sure(g.reason)))
    return rows


def _sure(reason: str) -> Sure:
    if "agrees with" in reason:
        return "other channel"
    if "can only be" in reason:
        return "physics"
    return "guess" if "no unit stated" in reason else "stated"


def _row_of(table: RawTable, column: RawColumn, to: str, unit: str, sign: int, why: str, sure: Sure) -> DraftColumn:
    turned = "turned round" if sign < 0 else ""
    return DraftColumn(table.label, column.name, to, unit, turned, why, sure, (), *span(column.numbers), column.first())


def _matched(
    tables: Sequence[RawTable], mapping: Mapping
) -> tuple[list[tuple[RawTable, TableMap]], list[DraftColumn], list[Fault]]:
    """Tables with the entries of a mapping whose columns they have."""
    pairs, rows, faults = [], [], []
    for table in tables:
        fitting = [entry for entry in mapping.tables if not _missing(table, entry)]
        named = [entry for entry in fitting if entry.file == table.file or entry.sheet == table.sheet]
        if fitting:
            entry = (named or fitting)[0]
            pairs.append((table, entry))
            rows += _mapped_rows(table, entry)
            continue
        near = min(mapping.tables, key=lambda entry: len(_missing(table, entry)))
        said = f"the mapping needs column {_missing(table, near)[0]!r}, which this table lacks"
        has = ", ".join(column.name for column in table.columns)
        faults.append(Fault(table.label, said, f"it has {has}", fatal=not table.sheet))
    if not pairs and not any(fault.fatal for fault in faults):
        faults = [replace(fault, fatal=True) for fault in faults]
    return pairs, rows, faults


def _missing(table: RawTable, entry: TableMap) -> list[str]:
    names = [*entry.time.columns, *(column.column for column in entry.columns)]
    return [name for name in names if table.column(name) is None]


def _mapped_rows(table: RawTable, entry: TableMap) -> list[DraftColumn]:
    said = {column.column: (column.to, column.unit, column.sign) for column in entry.columns}
    said |= {name: ("time", entry.time.form, 1) for name in entry.time.columns}
    rows = []
    for column in table.columns:
        told = said.get(column.name, (NOT_USED, column.unit, 1))
        why = "mapping" if column.name in said else "not in the mapping"
        rows.append(_row_of(table, column, *told, why, "stated"))
    return rows


def _without_rudder(tables: Sequence[RawTable], faults: Sequence[Fault]) -> list[Fault]:
    """The faults, with why no rudder is known as a fatal one."""
    near = [fault for fault in faults if fault.message.startswith("rudder")]
    if near or any(fault.fatal for fault in faults):
        return [replace(f, fatal=f.fatal or f in near, hint=MAP_HINT if f in near else f.hint) for f in faults]
    return [*faults, _no_rudder(tables)]


def _no_rudder(tables: Sequence[RawTable]) -> Fault:
    names = ", ".join(column.name for table in tables for column in table.columns)
    return Fault(
        tables[0].label,
        f"no column is surely the rudder angle; columns: {names}",
        MAP_HINT,
        fatal=True,
    )


# ------------------------------------------------------------------------------------------------ runs


def runs(streams: Sequence[Stream]) -> list[tuple[str, list[Stream]]]:
    """Streams sorted into runs: those with the same quantities are different runs, unless one goes on with another."""
    streams = _joined(streams)
    counts = Counter(frozenset(stream.quantities) for stream in streams)
    heads = [s for s in streams if {"rudder", "rudder_command"} & s.quantities.keys()]
    if max(counts.values()) == 1:
        return [(Path(heads[0].label.split(" [")[0]).stem, list(streams))]
    if len(counts) == 1:
        return [(_run_name(stream), [stream]) for stream in streams]
    return [(_run_name(head), [head, *_overlapping(head, [s for s in streams if s not in heads])]) for head in heads]


def _run_name(stream: Stream) -> str:
    file, _, sheet = stream.label.partition(" [")
    stem, sheet = Path(file).stem, sheet.rstrip("]").replace(" ", "_").replace("/", "_")
    return f"{stem}-{sheet}" if sheet else stem


def _overlapping(head: Stream, others: Sequence[Stream]) -> list[Stream]:
    return [s for s in others if s.dated and s.time[-1] > head.time[0] and s.time[0] < head.time[-1]]


def _joined(streams: Sequence[Stream]) -> list[Stream]:
    """Files of one logger that follow each other are joined."""
    out: list[Stream] = []
    for stream in sorted(streams, key=lambda s: s.time[0] if s.dated else 0.0):
        before = next((s for s in out if _goes_on(s, stream)), None)
        if before is None:
            out.append(stream)
            continue
        quantities = {k: np.concatenate([v, stream.quantities[k]]) for k, v in before.quantities.items()}
        time, kept = np.concatenate([before.time, stream.time]), np.concatenate([before.kept, stream.kept])
        done = (*before.done, *stream.done, f"{stream.label}: goes on with {before.label}, joined")
        parts = (*before.parts, stream.label)
        joined = replace(before, time=time, quantities=quantities, kept=kept, done=done, parts=parts)
        out[out.index(before)] = joined
    return out


def _goes_on(first: Stream, second: Stream) -> bool:
    gap = second.time[0] - first.time[-1]
    same = first.quantities.keys() == second.quantities.keys() and first.dated and second.dated
    return same and 0.0 < gap < SAME_RUN * max(first.step, second.step)


def _record(name: str, merged: Merged, options: Options) -> tuple[Record | None, list[str], list[Fault]]:
    """The record of a run, what was done, and faults."""
    made = derive(name, merged.time, merged.quantities, options.variation_deg)
    channels, constant = _living(name, made.found)
    faults = [*made.faults, *constant]
    known = np.isfinite(np.array(list(channels.values()))).any(axis=0) if channels else np.zeros(0, dtype=bool)
    if known.sum() < MIN_SAMPLES:
        fault = Fault(name, f"{int(known.sum())} samples", f"a record needs {MIN_SAMPLES}", fatal=True)
        return None, [], [*faults, fault]
    start = float(merged.time[0])
    meta = RecordMeta(vessel=options.vessel, source=", ".join(s.label for s in merged.streams), extra=made.facts)
    if merged.dated:
        stamp = datetime.datetime.fromtimestamp(start, datetime.UTC).isoformat(timespec="milliseconds")
        meta.extra["start_utc"] = stamp
    record = Record(merged.time - start, channels, name, meta)
    record, told, more = _signed(record, options.positive_rudder)
    more += [Fault(d.record, d.message, d.hint, column=d.column, fatal=d.fatal) for d in doubts(record)]
    notes = "; ".join(map(str, [*faults, *more])) or None
    record = replace(record, meta=replace(record.meta, notes=notes))
    return record, [*merged.steps, *made.steps, *told], [*faults, *more]


def _living(name: str, found: dict[str, np.ndarray]) -> tuple[dict[str, np.ndarray], list[Fault]]:
    """Channels without those that never change or have no value, dead sensors; a rudder may be held, which is told."""
    kept, faults = {}, []
    for channel, values in found.items():
        known = values[np.isfinite(values)]
        dead = known.size == 0 or (np.ptp(known) == 0.0 and channel not in MAY_BE_CONSTANT)
        said = f"{known[0]:.4g} in every row" if known.size else "no value"
        if dead and channel not in RUDDERS:
            faults.append(Fault(name, said, "a dead sensor? the channel is left out", column=channel))
            continue
        if dead:
            faults.append(Fault(name, said, "was the rudder held, or is its sensor dead?", column=channel))
        kept[channel] = values
    return kept, faults


def _signed(record: Record, given: Side | None) -> tuple[Record, list[str], list[Fault]]:
    """The record with the side of its positive rudder: as given, or told by the yaw response."""
    if given is not None:
        record = replace(record, meta=replace(record.meta, positive_rudder=given))
        doubt = rudder_sign_doubt(record)
        hint = "check --positive-rudder, or the signs of rudder and heading"
        said = f"the ship turns against a rudder that is positive to {given}"
        return record, [], [Fault(record.name, said, hint)] if doubt else []
    told = steering_side(record)
    if told is None:
        hint = "give --positive-rudder port or starboard"
        return record, [], [Fault(record.name, "the yaw response does not tell the rudder's sign", hint)]
    record = replace(record, meta=replace(record.meta, positive_rudder=told[0]))
    return record, [f"{record.name}: positive rudder turns the ship to {told[0]} (confidence {told[1]:.0%})"], []


def _aside(merged: Merged, tables: Sequence[tuple[Stream, RawTable]], mapping: Mapping) -> Aside:
    """Columns of the run's tables that are no channel, over the record's time; not where the time alone is left."""
    out: Aside = {}
    channels = {column.column for table in mapping.tables for column in table.columns}
    times = {name for table in mapping.tables for name in table.time.columns}
    for run in merged.streams:
        for stream, table in tables:
            if stream.label != run.label and stream.label not in run.parts:
                continue
            rest = [column for column in table.columns if column.name not in channels]
            if any(column.name not in times for column in rest):
                time = stream.time + run.shift_s - merged.time[0]
                own: dict[str, list[object]] = {c.name: [c.values[i] for i in stream.kept] for c in rest}
                out[table.label] = {"time_s": time.tolist(), **own}
    return out
