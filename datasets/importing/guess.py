"""What the columns of a log are: stated, told by other channels, bounded by physics, or asked."""

from __future__ import annotations

import re
from collections.abc import Mapping as Dict
from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from ...models.errors import BadInput
from ..io import MIN_SAMPLES
from . import meanings, other_channels, steering
from .draft import NOT_USED, for_equal_doubts, for_equal_headers
from .evidence import nearest
from .finding import ColumnFinding, ask_quantity, ask_unit, identifier
from .log import RawLog
from .mapping import ColumnMap, Mapping, TableMap
from .proposal import propose, propose_units
from .quantities import candidates, is_unsigned, quantities, unit_of
from .raw import RawTable
from .reading import stated
from .times import find_time

PASSES = 3
"""How often channels are compared: one that is told may tell the next."""
RUDDERS_AND_TURNING = ("rudder", "rudder_command", "heading", "heading_magnetic", "yaw_rate")
"""Quantities that a record is made for."""
MAY_BE_HELD = (
    "rudder", "rudder_command", "propeller", "propeller_thrust", "thrust_port", "thrust_starboard",
    "magnetic_variation", "magnetic_deviation", "wind_speed", "wind_direction",
)  # fmt: skip
"""Quantities that may be the same in every row of a record."""
TRUE = re.compile(
    r"true|gyro|kreisel|hdt|thdg|rwk|rechtweisend|vrai|verdader|\bvera\b|rettvisende|gps|gnss|真|[°g]\s?t\b|\(t\)|psi|yaw",
    re.IGNORECASE,
)
"""What says that a heading counts from true north, or comes from what does not know the magnetic one."""
MAGNETIC = ("heading_magnetic", "magnetic_variation", "magnetic_deviation")
"""Quantities that tell nothing more beside a heading from true north."""
CONFLICT = (0.7, 1.4)
"""Ratio of two channels outside of which a stated unit is questioned."""


def examine(tables: Sequence[RawTable], mapping: Mapping | None, answers: Dict[str, str]) -> RawLog:
    """The findings of all columns, as far as the log, the map and the answers tell them."""
    log = RawLog([], {}, for_equal_headers(tables, answers))
    for table in tables:
        entry = entry_of(table, mapping)
        log.times[table.label] = time = find_time(table, entry.time if entry else None, log.answers)
        given = _given(table, entry, mapping)
        own = (column for column in table.columns if column.name not in time.columns)
        log.findings += [stated(table, column, given.get(column.name), mapping is not None) for column in own]
    notes = {t.label for t in tables if t.n < MIN_SAMPLES and log.times[t.label].question is not None}
    if len(notes) < len(tables):  # a sheet of notes beside a log
        why = f"a table of less than {MIN_SAMPLES} rows without a time"
        log.findings = [f.unused(why) if f.table.label in notes and not f.bounded else f for f in log.findings]
    log.answers = for_equal_doubts(log.findings, log.answers)
    for i, found in enumerate(log.findings):
        vague = len(found.may_be) > 1 and not found.questions and identifier(found, "quantity") in log.answers
        # what an answer tells of other columns is told at once
        log.findings[i] = log.answered(ask_quantity(found, "", found.may_be) if vague else found)
    _chosen(log)
    for _ in range(PASSES):
        log.each(
            meanings.settle, other_channels.unit_by_channel, other_channels.by_physics, other_channels.sign_by_channel
        )
    steering.settle_rudders(log)
    steering.settle_propellers(log)
    propose(log, tables)
    log.each(other_channels.sign_by_channel, other_channels.as_rudder, _perhaps_magnetic, _not_needed)
    meanings.without_twins(log)
    other_channels.without_wind_from_bow(log)
    log.each(_checked, _without_dead)
    propose_units(log, tables)
    # the answer for one column's sign tells another's
    log.each(other_channels.sign_by_channel, meanings.ask, _ask_unit, other_channels.ask_open, other_channels.ask_open)
    if any(f.quantity == "heading" and "sign" in f.bounded for f in log.findings):  # an answer, which tells more
        log.each(lambda log, f: _checked(log, f) if f.quantity in ("yaw_rate", "sway") and f.signed else f)
    return log


def _given(table: RawTable, entry: TableMap | None, mapping: Mapping | None) -> dict[str, ColumnMap]:
    """Column -> what the map says of it; not of columns of the scale that is not wanted."""
    other = [c.name for c in table.columns if c.known == NOT_USED] if mapping is not None and mapping.scale else []
    if entry is not None and set(entry.time.columns) & set(other):
        names = ", ".join(entry.time.columns)
        raise BadInput(f"the time {names} is not of the scale {mapping.scale!r}" if mapping else "", file=table.label,
                       hint="state another time in the mapping, or '?' as its form")  # fmt: skip
    return {column.column: column for column in entry.columns if column.column not in other} if entry else {}


def _chosen(log: RawLog) -> None:
    """Columns that an answer makes the rudder, or what tells the turning."""
    for key in ("rudder", "turning"):
        label, _, quantity = log.answers.get(key, "").rpartition("/")
        for found in [f for f in log.findings if quantity and label == f"{f.table.label}/{f.column.name}"]:
            unit = unit_of(found.column.unit, quantities()[quantity].dimension)
            foreign = found.column.unit if unit is None else ""
            foreign = foreign or ("us" if quantity == "rudder" and steering.is_pulse(found.column.numbers) else "")
            log.change(found, replace(
                found, may_be=(quantity,), unit=unit, signed=is_unsigned(quantity), why=("as answered",),
                bounded=("quantity",), foreign=foreign, questions=(),
            ))  # fmt: skip


def entry_of(table: RawTable, mapping: Mapping | None) -> TableMap | None:
    """The entry of a map whose columns the table has."""
    if mapping is None:
        return None
    fitting = [entry for entry in mapping.tables if not missing(table, entry)]
    return max(fitting, key=lambda e: (e.file == table.file) + (e.sheet == table.sheet), default=None)


def missing(table: RawTable, entry: TableMap) -> list[str]:
    """Names of columns that an entry needs and the table lacks; one that uses none needs all."""
    used = [column.column for column in entry.columns if column.to != NOT_USED]
    used = used or [column.column for column in entry.columns]
    return [name for name in (*entry.time.columns, *used) if table.column(name) is None]


def _perhaps_magnetic(log: RawLog, found: ColumnFinding) -> ColumnFinding:
    """A heading that does not state from which north it counts, beside a variation: which one is asked."""
    said = " ".join((found.column.name, found.column.unit, *found.column.said))
    is_sure = found.questions or found.bounded or found.column.known or TRUE.search(said)
    if found.quantity != "heading" or is_sure or any("heading_magnetic" in f.may_be for f in log.findings):
        return found
    for other in log.findings:
        if other.quantity == "magnetic_variation" and np.any(np.nan_to_num(other.column.numbers)):
            name = found.column.name
            text = f"Does {name!r} count from true or from magnetic north? {other.column.name!r} is beside it."
            return ask_quantity(found, text, ("heading", "heading_magnetic"))
    return found


def _not_needed(log: RawLog, found: ColumnFinding) -> ColumnFinding:
    """What a record does not use, such as a speed through the water, unused; what a compass shows, or what corrects it,
    where a heading from true north is sure."""
    why = quantities()[found.quantity].unused if found.quantity is not None else ""
    if why and "quantity" not in found.bounded:
        return found.unused(why)
    if found.quantity not in MAGNETIC or found.bounded or found.column.known:
        return found
    true = next((f for f in log.findings if f.quantity == "heading" and f.unit and not f.questions), None)
    return found if true is None else found.unused(f"the heading from true north is column {true.column.name}")


def _checked(log: RawLog, found: ColumnFinding) -> ColumnFinding:
    """The finding, with a question where physics or another channel contradicts what is stated."""
    if found.quantity is None or found.questions or found.unit is None:
        return found
    if "unit" not in found.bounded:
        if other_channels.impossible(found):
            size = f"values up to {other_channels.size_of(found):.4g} {found.unit.name}"
            text = f"{found.column.name!r}: {size} cannot be. What is its unit?"
            opened = replace(found, factor=1.0)
            return ask_unit(opened, text, other_channels.possible(opened))
        raw = log.series(found, raw=True) if found.quantity in ("yaw_rate", "speed_over_ground", "surge") else None
        for name, size in other_channels.sizes(log, found, raw) if raw is not None else ():
            ratio, near = size / (found.unit.factor * found.factor), nearest(size, candidates(found.dimension), 0.15)
            # or the format states the unit, and no other one agrees
            if CONFLICT[0] < ratio < CONFLICT[1] or (near is None and found.column.known):
                break
            units = [*([near] if near else []), found.unit]
            said = f"says {found.unit.name}, but {name} is {ratio:.3g} times as fast"
            text = f"{found.column.name!r} {said}: what is its unit?"
            return ask_unit(replace(found, factor=1.0), text, tuple(dict.fromkeys(units)))
    return other_channels.checked(log, found) if found.signed and "sign" not in found.bounded else found


def _without_dead(_: RawLog, found: ColumnFinding) -> ColumnFinding:
    """A column that shows one number in every row unused where something is open about it that an answer would tell: a
    record leaves such channels out."""
    known = found.column.finite if found.may_be and found.column.numeric else np.zeros(0)
    still = known.size > MIN_SAMPLES and float(np.ptp(known)) == 0.0
    held = {*MAY_BE_HELD} & {*found.may_be} or found.bounded or found.column.known
    opened = found.questions or found.unit is None or not found.signed or len(found.may_be) > 1
    return found.unused("the same number in every row: no motion") if still and opened and not held else found


def _ask_unit(log: RawLog, found: ColumnFinding) -> ColumnFinding:
    """The finding with the question for its unit, if it is open; unused where nothing would be done with the answer."""
    if found.quantity is None or found.unit is not None or found.questions:
        return found
    known = found.column.finite
    if known.size and np.ptp(known) == 0.0 and known[0] == 0.0 and found.quantity not in RUDDERS_AND_TURNING:
        return found.unused("0 in every row")
    if found.quantity == "propeller_thrust":
        return found.unused("its unit is not stated, and a record needs none; the map can state it")
    rudder = next((f for f in log.findings if f.quantity == "rudder" and f.unit and not f.questions), None)
    if found.quantity == "rudder_command" and rudder is not None and not found.foreign and not found.bounded:
        return found.unused(f"its unit is not stated, and the rudder is column {rudder.column.name}")
    return other_channels.ask_for_unit(found)
