"""What steers a craft: a rudder without a known name, what tells the turning, and two fixed propellers in place of a
rudder, told by names and by the yaw rate."""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence
from collections.abc import Mapping as Dict
from dataclasses import dataclass, replace
from itertools import combinations

import numpy as np

from ..rudder_sign import SIGN_SHARE
from ..yaw_response import yaw_response
from .beside import of_side
from .draft import NOT_USED, Answer, Question
from .evidence import ClockSeries, together
from .finding import WITH_SIDE, ColumnFinding, line_of
from .headers import PERCENT
from .log import RawLog
from .mapping import Mapping, flow
from .names import named, words
from .quantities import quantities, word_list
from .raw import RawTable
from .units import UNITS, tidy, unit_of

RUDDER, TURNING = "rudder", "turning"
"""Ids of the questions."""
PROPELLERS = "propellers"
"""Id of the question which columns are two propellers that steer."""
TELL_TURNING = {"heading", "heading_magnetic", "yaw_rate", "latitude", "north"}
"""Quantities of which one tells the turning of a ship."""
NONE = "none"
"""The answer that there is no rudder."""
LARGEST_DEG = 60.0
PULSE_US, PER_CENT = (700.0, 2300.0), 100.0
"""Range of a servo's pulse, and of a share of the largest angle."""
NAMELESS = ("no known name", "not in the map")
"""Why a column that may be anything is not used."""
DECIDED = ("the map says so", "not used, as answered")
"""Why a column is not used that the user left out."""
ACCELERATIONS = frozenset({"accel", "acceleration", "acc", "accy"})
"""Words for what a yaw rate follows as it does a rudder."""


def questions(
    tables: Sequence[RawTable], log: RawLog, mapping: Mapping | None, answers: Dict[str, str]
) -> list[Question]:
    """Questions for the column of the rudder, and for one that tells the turning, where none is known or asked."""
    may_be = {quantity for f in log.findings for quantity in f.may_be}
    asked = []
    opened = any(question.id == PROPELLERS for f in log.findings for question in f.questions)
    none = answers.get(RUDDER) == NONE or (mapping is not None and mapping.rudder == NONE)
    if is_unsteered(may_be) and not opened and not none and (able := _rudders(log)):
        asked.append(_which_rudder(able))
    if not may_be & TELL_TURNING and (turning := _which_turning(tables, log)) is not None:
        asked.append(turning)
    return asked


def lacks_turning(tables: Sequence[RawTable], log: RawLog) -> bool:
    """Whether no column is, or can be, one that tells the turning."""
    may_be = {quantity for f in log.findings for quantity in f.may_be}
    return not may_be & TELL_TURNING and _which_turning(tables, log) is None


def is_unsteered(quantities_of_log: set[str]) -> bool:
    """Whether none of the quantities is what a ship is steered by."""
    return not quantities_of_log & set(WITH_SIDE) and not quantities_of_log >= {"thrust_port", "thrust_starboard"}


def _rudders(log: RawLog) -> list[ColumnFinding]:
    """Columns that could be the rudder: called so and not read, or without a known name, as large as a rudder, and the
    yaw rate answers them, where there is one: that of a sensor, a heading, or a track."""
    angles = [s for _, s in log.all("heading", "heading_magnetic", signed=False)] or [s for _, s in log.turns()]
    turning = [series for _, series in log.all("yaw_rate", signed=False)] or list(map(_derivative, angles))
    return [f for f in log.findings if _is_called(f) or (_is_servo_like(f) and _answered_by(log, f, turning))]


def _is_refused(found: ColumnFinding) -> bool:
    """Whether the name of a column says that it is something else: then only what answers it tells."""
    return set(found.why).isdisjoint(NAMELESS)


def _is_called(found: ColumnFinding) -> bool:
    """Whether an unused column that varies is called a rudder."""
    column = found.column
    called = set(named(words(column.called or column.name)).may_be) & set(WITH_SIDE)
    known = column.finite
    own = not column.known and not set(found.why) & set(DECIDED)
    return bool(called) and own and not found.may_be and column.numeric and float(np.ptp(known)) > 0.0


def _derivative(angle: ClockSeries) -> ClockSeries:
    known = np.isfinite(angle.values) & np.isfinite(angle.time)
    time, values = angle.time[known], np.unwrap(angle.values[known])
    rises = np.diff(time, prepend=-np.inf) > 0.0
    time, values = time[rises], values[rises]
    return replace(angle, time=time, values=np.gradient(values, time) if time.size > 1 else np.zeros(time.size))


def _is_servo_like(found: ColumnFinding) -> bool:
    """Whether an unused column without a known name has the size and the unit of a rudder."""
    column = found.column
    if found.may_be or column.known or set(found.why) & set(DECIDED) or not column.numeric:
        return False
    if _is_refused(found) and set(words(column.name)) & ACCELERATIONS:
        return False
    if column.unit and unit_of(column.unit) is not None and unit_of(column.unit, "angle") is None:
        return False
    known = column.finite
    low, high = np.quantile(known, [0.01, 0.99]).tolist()
    if low == high or np.unique(known).size < 3:
        return False
    either_side = low < 0.0 < high and -low < 10.0 * high and high < -10.0 * low
    return is_pulse(known) or (either_side and max(-low, high) <= max(LARGEST_DEG, PER_CENT))


def is_pulse(numbers: np.ndarray) -> bool:
    """Whether numbers (N,) may be the pulses of a servo, in us, to both sides of its middle."""
    known = numbers[np.isfinite(numbers)]
    low, high = np.quantile(known, [0.01, 0.99]).tolist() if known.size else (0.0, 0.0)
    return PULSE_US[0] <= low < 1500.0 < high <= PULSE_US[1]


def _answered_by(log: RawLog, found: ColumnFinding, turning: Sequence[ClockSeries]) -> bool:
    """Whether a yaw rate answers the column as one answers a rudder; also where none can be compared with it."""
    series = log.series(found, raw=True)
    compared = [] if series is None else [share for r in turning if (share := response(series, r)) is not None]
    if series is None or not compared:
        return not _is_refused(found)
    return any(compared)


def response(steering: ClockSeries, rate: ClockSeries) -> float | None:
    """The share of the yaw rate that what steers explains, with the sign of its gain; 0 where it explains little, None
    where they cannot be compared."""
    shared = together(steering, rate)
    if shared is None or not np.ptp(shared[1]) > 0.0 or not np.ptp(shared[2]) > 0.0:
        return None
    told = yaw_response(shared[0], shared[2], shared[1])
    return told.share * told.gain if told is not None and told.is_sure(SIGN_SHARE) else 0.0


def _which_rudder(able: Sequence[ColumnFinding]) -> Question:
    listed = ", ".join(f.column.name for f in able)
    answers = tuple(_as(f, RUDDER) for f in able)
    none = Answer(NONE, "there is no rudder in this log: sensors can be checked, no model identified", "rudder: none")
    text = f"No column is known to be the rudder angle: is it one of these, or is there none? Columns: {listed}."
    first = able[0]
    return Question(RUDDER, "quantity", first.table.label, first.column.name, text, (*answers, none), without=NONE)


def _which_turning(tables: Sequence[RawTable], log: RawLog) -> Question | None:
    """The question which column tells the turning; None where none can."""
    able = [(f, quantity) for f in log.findings for quantity in ("heading", "yaw_rate") if _may_turn(f, quantity)]
    answers = tuple(_as(f, quantity) for f, quantity in able)
    names = ", ".join(dict.fromkeys(f.column.name for f, _ in able))
    if not able:
        return None
    text = f"No column is known to be the heading or the yaw rate: which one is it? Columns: {names}."
    return Question(TURNING, "quantity", tables[0].label, tables[0].columns[0].name, text, answers)


def _may_turn(found: ColumnFinding, quantity: str) -> bool:
    """Whether a column can be the heading or the yaw rate: its numbers vary, its name is that of one or not known, and
    its unit is none of something else."""
    known = found.column.finite if found.column.numeric else np.zeros(0)
    if not known.size or not np.ptp(known) > 0.0:
        return False
    parts = words(found.column.called or found.column.name)
    if found.may_be or _is_refused(found):
        return quantity in {*found.may_be, *(one for part in parts for one in named((part,)).may_be)}
    unit = unit_of(found.column.unit) if found.column.unit else None
    if found.column.unit and tidy(found.column.unit) in PERCENT:
        return False
    return unit is None or unit.dimension == quantities()[quantity].dimension


def _as(found: ColumnFinding, quantity: str) -> Answer:
    line = flow({"column": found.column.name, "to": quantity, "unit": "?"})
    text = f"{found.column.name} is the {quantity.replace('_', ' ')}"
    return Answer(f"{found.table.label}/{found.column.name}/{quantity}", text, line)


# ---- Two fixed propellers: their pair is told by names and by the yaw rate.

PORT, STARBOARD = "thrust_port", "thrust_starboard"
NEUTRAL_US = 1500.0
MOST, MOST_WAYS = 24, 8
"""Columns without a name of a side above which pairs are not tried, and answers that are shown."""


@dataclass(frozen=True)
class _Pair:
    """Places of the findings of port and starboard; `sided`: their names say which is which; `share` of the yaw rate
    that port less starboard explains, with its sign, None where no yaw rate tells; `signed`: that one's sign is known.
    """

    port: int
    starboard: int
    sided: bool
    share: float | None
    signed: bool


def settle_propellers(log: RawLog) -> None:
    """Make two columns the thrusts to port and starboard where a craft has no rudder, or ask which ones they are."""
    if not is_unsteered({quantity for f in log.findings for quantity in f.may_be}):
        return
    pairs = list(_pairs(log))
    if PROPELLERS in log.answers:
        if way := _ways(log, pairs).get(log.answers[PROPELLERS]):
            _use(log, way, "as answered")
        return
    if not pairs:
        return
    best = max(pairs, key=lambda pair: (pair.sided, abs(pair.share or 0.0)))
    against = best.sided and best.signed and best.share is not None and best.share < 0.0
    agrees = best.signed and best.share is not None and best.share > 0.0
    both = (log.findings[best.port], log.findings[best.starboard])
    in_newtons = all(unit_of(f.column.unit, "force") or _named_force(f) for f in both)
    if best.sided and (agrees or (in_newtons and not against)):
        why = "the names state the side" + (", and the yaw rate answers their difference" if agrees else "")
        _use(log, (best.port, best.starboard), why)
    else:
        found, question = log.findings[best.port], _question(log, pairs, against)
        why, questions = (*found.why, "a propeller?"), (*found.questions, question)
        log.findings[best.port] = replace(found, why=why, questions=questions, sure="guess")


def _named_force(found: ColumnFinding) -> bool:
    return found.column.name.endswith(("_N", "_kN", "(N)", "[N]", "(kN)", "[kN]"))


def _pairs(log: RawLog) -> Iterator[_Pair]:
    """Pairs of columns that may be two propellers."""
    able = {i: f for i, f in enumerate(log.findings) if _may_drive(f)}
    done = set()
    for label in dict.fromkeys(f.table.label for f in able.values()):
        own = {f.column.name: i for i, f in able.items() if f.table.label == label}
        columns = [log.findings[i].column for i in own.values()]
        sides = {side: of_side(columns, side) for side in ("port", "starboard")}
        for key, ports in sides["port"].items():
            starboards = sides["starboard"].get(key, [])
            if len(ports) != 1 or len(starboards) != 1:
                continue
            i, j = own[columns[ports[0]].name], own[columns[starboards[0]].name]
            pair = _pair(log, i, j, sided=True)
            drives = {re.sub(r"\d+$", "", word) for word in key[0]} & word_list("actuators")
            if drives or (pair.share and _opposed(log, i, j)):
                done |= {i, j}
                yield pair
        rest = [i for i in own.values() if i not in done]
        if not done and len(rest) <= MOST:
            yield from (pair for pair in _numbered(log, rest) if pair.share)


def _may_drive(found: ColumnFinding) -> bool:
    """Whether a column is not used for its name, or is a thrust or revolutions of one of several propellers."""
    column = found.column
    known = column.finite
    free = not found.may_be and not column.known and "the map says so" not in found.why
    driven = bool(found.may_be) and set(found.may_be) <= {"propeller", "propeller_thrust", PORT, STARBOARD}
    mapped = "quantity" in found.bounded
    return (free or driven) and not mapped and column.numeric and known.size > 0 and float(np.ptp(known)) > 0.0


def _numbered(log: RawLog, places: list[int]) -> Iterator[_Pair]:
    """Pairs of columns whose names differ in a number only, and of equal units."""
    for i, j in combinations(places, 2):
        one, two = log.findings[i].column, log.findings[j].column
        alike = re.sub(r"\d+", "#", one.name) == re.sub(r"\d+", "#", two.name) and one.name != two.name
        if alike and one.unit == two.unit and _opposed(log, i, j):
            yield _pair(log, i, j, sided=False)


def _opposed(log: RawLog, one: int, other: int) -> bool:
    """Whether a yaw rate answers two columns the opposite way."""
    series = [log.series(log.findings[i], raw=True) for i in (one, other)]
    for _, rate in log.all("yaw_rate", signed=False):
        shares = [response(s, rate) for s in series if s is not None]
        if len(shares) == 2 and all(shares):
            return (shares[0] or 0.0) * (shares[1] or 0.0) < 0.0
    return False


def _pair(log: RawLog, port: int, starboard: int, sided: bool) -> _Pair:
    one, two = (log.series(log.findings[i], raw=True) for i in (port, starboard))
    shared = together(one, two) if one is not None and two is not None else None
    if shared is not None and one is not None:
        difference = ClockSeries(shared[0], shared[1] - shared[2], one.clock, one.dated)
        for signed in (True, False):
            for _, rate in log.all("yaw_rate", signed=signed):
                share = response(difference, rate)
                if share is not None:
                    return _Pair(port, starboard, sided, share, signed)
    return _Pair(port, starboard, sided, None, False)


def _use(log: RawLog, places: tuple[int, int], why: str) -> None:
    """Make two columns, by their places, the thrusts to port and starboard."""
    for place, quantity in zip(places, (PORT, STARBOARD), strict=True):
        found = log.findings[place]
        unit = unit_of(found.column.unit, "force") or (UNITS["kN"] if found.column.name.endswith("kN") else None)
        newtons = unit is not None or _named_force(found)
        told = why if newtons else f"{why}; in the file's own unit, one of it counts as 1 N"
        made = _as_thrust(replace(found, may_be=(quantity,), unit=unit or UNITS["N"]))
        sure = "stated" if newtons else "guess"
        log.findings[place] = replace(made, signed=True, questions=(), sure=sure, why=(told,))


def _as_thrust(found: ColumnFinding) -> ColumnFinding:
    """A column whose numbers are a thrust; those of a servo's pulse are 1500 us at rest."""
    known = found.column.finite
    pulse = PULSE_US[0] <= known.min() and known.max() <= PULSE_US[1] and known.max() > 1000.0
    return replace(found, factor=1.0, offset=-NEUTRAL_US if pulse else 0.0, sign=1)


def _ways(log: RawLog, pairs: Sequence[_Pair]) -> dict[str, tuple[int, int]]:
    """Key of an answer -> places of port and starboard, both ways round of every pair, the likeliest first."""
    out: dict[str, tuple[int, int]] = {}
    for pair in sorted(pairs, key=lambda pair: (not pair.sided, -abs(pair.share or 0.0))):
        ways = [(pair.port, pair.starboard), (pair.starboard, pair.port)]
        turned = pair.signed and pair.share is not None and pair.share < 0.0
        for way in reversed(ways) if turned else ways:
            out.setdefault(", ".join(log.findings[i].column.name for i in way), way)
    return out


def _question(log: RawLog, pairs: Sequence[_Pair], against: bool) -> Question:
    answers = [_answer(log, key, way) for key, way in list(_ways(log, pairs).items())[:MOST_WAYS]]
    best = max(pairs, key=lambda pair: (pair.sided, abs(pair.share or 0.0)))
    first, second = log.findings[best.port], log.findings[best.starboard]
    names = f"{first.column.name} and {second.column.name}"
    text = f"There is no rudder: do the two propellers {names} steer the craft, and which one is on the port side?"
    text += " The yaw rate answers them the other way round than their names say." if against else ""
    none = Answer(NOT_USED, "none of them is used", line_of(first, to=NOT_USED))
    return Question(PROPELLERS, "quantity", first.table.label, first.column.name, text, (*answers, none))


def _answer(log: RawLog, key: str, way: tuple[int, int]) -> Answer:
    one, two = (log.findings[i] for i in way)
    text = f"{one.column.name} to port, {two.column.name} to starboard; their difference steers, their mean drives"
    pairs = ((one, PORT), (two, STARBOARD))
    return Answer(key, text, "\n".join(line_of(_as_thrust(f), to=quantity, unit="N") for f, quantity in pairs))
