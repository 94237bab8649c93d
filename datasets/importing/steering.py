"""What steers a craft: a rudder without a known name, the order of a rudder, what tells the turning, and two fixed
propellers in place of a rudder, told by names and by the yaw rate."""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence
from collections.abc import Mapping as Dict
from dataclasses import replace
from itertools import combinations
from typing import NamedTuple

import numpy as np

from ..yaw_response import SIGN_SHARE, yaw_response
from .beside import of_side
from .draft import NOT_USED, Answer, Question
from .evidence import FEWEST, ClockSeries, best_lag, cosine, known, liveliest, together
from .finding import WITH_SIDE, ColumnFinding, ask_quantity, line_of
from .headers import PERCENT
from .log import RawLog
from .mapping import Mapping, flow
from .names import named, words
from .quantities import UNITS, LogUnit, quantities, tidy, unit_of, word_list
from .raw import RawTable

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
) -> list[Question] | None:
    """Questions for the column of the rudder, and for one that tells the turning, where none is known or asked; None
    where none is, or can be, one that tells the turning."""
    may_be = {quantity for f in log.findings for quantity in f.may_be}
    turning: list[Question] | None = []
    if not may_be & TELL_TURNING:
        turns = [(f, quantity) for f in log.findings for quantity in ("heading", "yaw_rate") if _may_turn(f, quantity)]
        names = ", ".join(dict.fromkeys(f.column.name for f, _ in turns))
        text = f"No column is known to be the heading or the yaw rate: which one is it? Columns: {names}."
        told = tuple(_as(f, quantity) for f, quantity in turns)
        asked = Question(TURNING, "quantity", tables[0].label, tables[0].columns[0].name, text, told)
        turning = [asked] if turns else None
    opened = any(question.id == PROPELLERS for f in log.findings for question in f.questions)
    none = answers.get(RUDDER) == NONE or (mapping is not None and mapping.rudder == NONE)
    if turning is None or not is_unsteered(may_be) or opened or none:
        return turning
    able = _rudders(log)
    if not able:
        return turning
    listed = ", ".join(f.column.name for f in able)
    text = f"No column is known to be the rudder angle: is it one of these, or is there none? Columns: {listed}."
    rest = Answer(NONE, "there is no rudder in this log: sensors can be checked, no model identified", "rudder: none")
    place, made = (able[0].table.label, able[0].column.name), tuple(_as(f, RUDDER) for f in able)
    return [Question(RUDDER, "quantity", *place, text, (*made, rest), without=NONE), *turning]


def is_unsteered(quantities_of_log: set[str]) -> bool:
    """Whether none of the quantities is what a ship is steered by."""
    return not quantities_of_log & set(WITH_SIDE) and not quantities_of_log >= {"thrust_port", "thrust_starboard"}


def _rudders(log: RawLog) -> list[ColumnFinding]:
    """Columns that could be the rudder: called so and not read, or without a known name, as large as a rudder, and the
    yaw rate answers them, where there is one: that of a sensor, a heading, or a track."""
    turning = [series for _, series in log.all("yaw_rate", signed=False)]
    if not turning:
        angles = [s for _, s in log.all("heading", "heading_magnetic", signed=False)] or [s for _, s in log.turns()]
        for angle, (time, values) in ((angle, known(angle, angle=True)) for angle in angles):
            rate = np.gradient(values, time) if time.size > 1 else np.zeros(time.size)
            turning.append(replace(angle, time=time, values=rate))
    able = []
    for found in log.findings:
        column = found.column
        own = not (column.known or set(found.why) & set(DECIDED) or found.may_be) and column.numeric
        servo = own and _is_servo_like(found)
        series = log.series(found, raw=True) if servo else None
        shares = [share for r in turning if (share := response(series, r)) is not None] if series is not None else []
        answers = any(shares) if shares else not _is_refused(found)  # where nothing can be compared the name tells
        if (own and is_called_rudder(found) and float(np.ptp(column.finite)) > 0.0) or (servo and answers):
            able.append(found)
    return able


def is_called_rudder(found: ColumnFinding) -> bool:
    """Whether a column has the name of a rudder, or of its order."""
    return bool(set(named(words(found.column.called or found.column.name)).may_be) & set(WITH_SIDE))


def _is_refused(found: ColumnFinding) -> bool:
    """Whether the name of a column says that it is something else: then only what answers it tells."""
    return set(found.why).isdisjoint(NAMELESS)


def _is_servo_like(found: ColumnFinding) -> bool:
    """Whether a column of numbers has the size and the unit of a rudder, and no name of something else."""
    column = found.column
    if _is_refused(found) and set(words(column.name)) & ACCELERATIONS:
        return False
    if column.unit and unit_of(column.unit) is not None and unit_of(column.unit, "angle") is None:
        return False
    low, high = np.quantile(column.finite, [0.01, 0.99]).tolist()
    if low == high or np.unique(column.finite).size < 3:
        return False
    either_side = low < 0.0 < high and -low < 10.0 * high and high < -10.0 * low
    return is_pulse(column.finite) or (either_side and max(-low, high) <= max(LARGEST_DEG, PER_CENT))


def is_pulse(numbers: np.ndarray) -> bool:
    """Whether numbers (N,) may be the pulses of a servo, in us, to both sides of its middle."""
    known = numbers[np.isfinite(numbers)]
    low, high = np.quantile(known, [0.01, 0.99]).tolist() if known.size else (0.0, 0.0)
    return PULSE_US[0] <= low < 1500.0 < high <= PULSE_US[1]


def response(steering: ClockSeries, rate: ClockSeries) -> float | None:
    """The share of the yaw rate that what steers explains, with the sign of its gain; 0 where it explains little, None
    where they cannot be compared."""
    shared = together(steering, rate)
    if shared is None or not np.ptp(shared[1]) > 0.0 or not np.ptp(shared[2]) > 0.0:
        return None
    told = yaw_response(shared[0], shared[2], shared[1])
    return told.share * told.gain if told is not None and told.is_sure(SIGN_SHARE) else 0.0


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
IN_NEWTONS = ("_N", "_kN", "(N)", "[N]", "(kN)", "[kN]")
"""Ends of the names of columns in newtons."""
MOST, MOST_WAYS = 24, 8
"""Columns without a name of a side above which pairs are not tried, and answers that are shown."""


def settle_propellers(log: RawLog) -> None:
    """Make two columns the thrusts to port and starboard where a craft has no rudder, or ask which ones they are."""
    if not is_unsteered({quantity for f in log.findings for quantity in f.may_be}):
        return
    pairs = sorted(_pairs(log), key=lambda pair: (not pair.sided, -abs(pair.share or 0.0)))
    ways: dict[str, tuple[ColumnFinding, ColumnFinding]] = {}  # both ways round of every pair, the likeliest first
    for pair in pairs:
        turned = pair.signed and (pair.share or 0.0) < 0.0
        for way in ((pair.starboard, pair.port), (pair.port, pair.starboard))[:: 1 if turned else -1]:
            ways.setdefault(", ".join(found.column.name for found in way), way)
    if PROPELLERS in log.answers:
        if way := ways.get(log.answers[PROPELLERS]):
            _use(log, way, "as answered")
        return
    if not pairs:
        return
    both, share = (pairs[0].port, pairs[0].starboard), (pairs[0].share or 0.0) if pairs[0].signed else 0.0
    against, agrees = pairs[0].sided and share < 0.0, share > 0.0
    in_newtons = all(unit_of(f.column.unit, "force") or f.column.name.endswith(IN_NEWTONS) for f in both)
    if pairs[0].sided and (agrees or (in_newtons and not against)):
        _use(log, both, "the names state the side" + (", and the yaw rate answers their difference" if agrees else ""))
        return
    names = " and ".join(found.column.name for found in both)
    text = f"There is no rudder: do the two propellers {names} steer the craft, and which one is on the port side?"
    text += " The yaw rate answers them the other way round than their names say." if against else ""
    answers = [
        Answer(
            key,
            f"{one.column.name} to port, {two.column.name} to starboard; their difference steers, their mean drives",
            "\n".join(line_of(_as_thrust(f, q, UNITS["N"])) for f, q in ((one, PORT), (two, STARBOARD))),
        )
        for key, (one, two) in list(ways.items())[:MOST_WAYS]
    ]
    none = Answer(NOT_USED, "none of them is used", line_of(both[0], to=NOT_USED))
    place = both[0].table.label, both[0].column.name
    question = Question(PROPELLERS, "quantity", *place, text, (*answers, none))
    why, questions = (*both[0].why, "a propeller?"), (*both[0].questions, question)
    log.change(both[0], replace(both[0], why=why, questions=questions, sure="guess"))


class PropellerPair(NamedTuple):
    """Columns of port and starboard; `sided`: their names say which is which; `share` of the yaw rate that port less
    starboard explains, with its sign, None where no yaw rate tells; `signed`: that one's sign is known."""

    port: ColumnFinding
    starboard: ColumnFinding
    sided: bool
    share: float | None
    signed: bool


def _pairs(log: RawLog) -> Iterator[PropellerPair]:
    """Pairs of columns that may be two propellers: not used for their names, or a thrust or revolutions of one of
    several.  Names state the sides; those without sides differ in a number only, and the units are equal."""
    able = []
    for found in log.findings:
        column, drives = found.column, {"propeller", "propeller_thrust", PORT, STARBOARD}
        free = not found.may_be and not column.known and "the map says so" not in found.why
        driven = bool(found.may_be) and set(found.may_be) <= drives
        varies = column.numeric and column.finite.size > 0 and float(np.ptp(column.finite)) > 0.0
        able += [found] if (free or driven) and "quantity" not in found.bounded and varies else []
    sided = False
    for label in dict.fromkeys(f.table.label for f in able):
        own = [f for f in able if f.table.label == label]
        sides = {side: of_side([f.column for f in own], side) for side in ("port", "starboard")}
        for key, ports in sides["port"].items():
            starboards = sides["starboard"].get(key, [])
            if len(ports) != 1 or len(starboards) != 1:
                continue
            port, starboard = own[ports[0]], own[starboards[0]]
            drives = {re.sub(r"\d+$", "", word) for word in key[0]} & word_list("actuators")
            told = _difference(log, port, starboard)
            if drives or (told[0] and _opposed(log, port, starboard)):
                sided = True
                yield PropellerPair(port, starboard, True, *told)
        if sided or len(own) > MOST:
            continue
        for port, starboard in combinations(own, 2):
            one, two = port.column, starboard.column
            alike = re.sub(r"\d+", "#", one.name) == re.sub(r"\d+", "#", two.name) and one.name != two.name
            if alike and one.unit == two.unit and _opposed(log, port, starboard):
                told = _difference(log, port, starboard)
                if told[0]:
                    yield PropellerPair(port, starboard, False, *told)


def _difference(log: RawLog, port: ColumnFinding, starboard: ColumnFinding) -> tuple[float | None, bool]:
    """(share of the yaw rate that the difference of two columns explains, whether the sign of that rate is known)."""
    one, two = (log.series(found, raw=True) for found in (port, starboard))
    shared = together(one, two) if one is not None and two is not None else None
    if shared is not None and one is not None:
        difference = ClockSeries(shared[0], shared[1] - shared[2], one.clock, one.dated)
        for signed in (True, False):
            for _, rate in log.all("yaw_rate", signed=signed):
                share = response(difference, rate)
                if share is not None:
                    return share, signed
    return None, False


def _opposed(log: RawLog, one: ColumnFinding, other: ColumnFinding) -> bool:
    """Whether a yaw rate answers two columns the opposite way."""
    series = [log.series(found, raw=True) for found in (one, other)]
    for _, rate in log.all("yaw_rate", signed=False):
        shares = [response(s, rate) for s in series if s is not None]
        if len(shares) == 2 and all(shares):
            return (shares[0] or 0.0) * (shares[1] or 0.0) < 0.0
    return False


def _use(log: RawLog, way: tuple[ColumnFinding, ColumnFinding], why: str) -> None:
    """Make two columns the thrusts to port and starboard."""
    for found, quantity in zip(way, (PORT, STARBOARD), strict=True):
        unit = unit_of(found.column.unit, "force") or (UNITS["kN"] if found.column.name.endswith("kN") else None)
        newtons = unit is not None or found.column.name.endswith(IN_NEWTONS)
        told = why if newtons else f"{why}; in the file's own unit, one of it counts as 1 N"
        made = _as_thrust(found, quantity, unit or UNITS["N"])
        made = replace(made, signed=True, questions=(), sure="stated" if newtons else "guess", why=(told,))
        log.change(found, made)


def _as_thrust(found: ColumnFinding, quantity: str, unit: LogUnit) -> ColumnFinding:
    """A column whose numbers are a thrust; those of a servo's pulse are 1500 us at rest."""
    known = found.column.finite
    pulse = PULSE_US[0] <= known.min() and known.max() <= PULSE_US[1] and known.max() > 1000.0
    return replace(found, may_be=(quantity,), unit=unit, factor=1.0, offset=-NEUTRAL_US if pulse else 0.0, sign=1)


# ---- Order and answer of a rudder: of two columns that move alike the earlier one is the order, whatever the names.

ACTUAL, ORDER = WITH_SIDE
SMOOTHED = frozenset({"filtered", "filter", "smoothed", "smooth", "avg", "average", "mean"})
"""Words for a copy that is late by a filter."""
SAME_RANGE = (0.6, 1.7)
"""Ratio of the ranges of an order and its answer."""
ALIKE, LONGEST_S = 0.8, 30.0
"""Correlation of an order and its answer, at a lag of up to so many seconds."""
SERVO, CLEARER = 0.25, 0.2
"""Correlation of a rudder's movement with what is left to the order from which on it follows it, and by how much that
must be more than the other way round."""
APART = 0.03
"""Share of its range by which a rudder must be from its order for the lag to tell."""
LEAST_STEP = 0.1
"""Share of the range that a step of an order is, not one of the resolution."""
STEPPED, SLEWED = 0.8, 0.4
"""Share of all movement in single steps: of an order above the first, of a rudder below the second."""


def settle_rudders(log: RawLog) -> None:
    """Make the earlier of two rudders the order and the later one the rudder; ask where a name says the opposite."""
    able = [i for i, found in enumerate(log.findings) if _may_steer(found)]
    for pair in combinations(able, 2):
        one, two = (log.findings[i] for i in pair)
        first, second = (log.series(f, raw=True) for f in (one, two))
        if not (_may_steer(one) and _may_steer(two)) or first is None or second is None:  # or an earlier pair told it
            continue
        earlier = lead(first, second)
        order, rudder = (one, two) if earlier > 0 else (two, one)
        limited = order.may_be == rudder.may_be == (ORDER,)  # an order and what limits it
        if not earlier or limited or "quantity" in (*order.bounded, *rudder.bounded):
            continue
        if rudder.may_be == (ORDER,) and order.may_be != (ORDER,):
            # the names say the opposite: which one is the order?
            text = (
                f"{rudder.column.name!r} is called an order, and it follows {order.column.name!r}: is it the rudder, "
                f"and {order.column.name!r} the order?"
            )
            settled = log.answered(ask_quantity(rudder, text, (ACTUAL, ORDER)))
            made = order, settled
            if settled.may_be and not settled.questions:
                other, bounded = ORDER if settled.quantity == ACTUAL else ACTUAL, (*order.bounded, "quantity")
                order_then = replace(order, may_be=(other,), signed=other == ACTUAL, bounded=bounded)
                made = order_then, replace(settled, signed=settled.quantity == ACTUAL)
        else:
            made = (
                _in_role(order, ORDER, f"the order: column {rudder.column.name} follows it"),
                _in_role(rudder, ACTUAL, f"the answer: it follows column {order.column.name}"),
            )
        for found, told in zip((order, rudder), made, strict=True):
            log.change(found, told)


def _may_steer(found: ColumnFinding) -> bool:
    rudder = bool(found.may_be) and set(found.may_be) <= set(WITH_SIDE) and found.column.numeric
    return rudder and not set(words(found.column.name)) & SMOOTHED


def _in_role(found: ColumnFinding, quantity: str, why: str) -> ColumnFinding:
    """A column in its role; a doubt about its name is settled by that."""
    if found.may_be == (quantity,) and not any(q.about == "quantity" for q in found.questions):
        return found if why in found.why else replace(found, why=(*found.why, why))
    kept = tuple(q for q in found.questions if q.about != "quantity")
    sure = "other channel" if found.sure == "guess" and not kept else found.sure
    found = replace(found, questions=kept, sure=sure)
    return found.told("other channel", why, may_be=(quantity,), signed=quantity == ACTUAL)


def lead(first: ClockSeries, second: ClockSeries) -> int:
    """1 where the first of two series is the order of the second, -1 the other way round, 0 where nothing tells it."""
    return steps(first, second) or (leads(first, second) if first.clock == second.clock else 0)


def leads(first: ClockSeries, second: ClockSeries) -> int:
    """1 where the second series follows the first as a rudder its order, -1 the other way round, 0 where neither."""
    shared = together(first, second)
    if shared is None:
        return 0
    time, a, b = liveliest(*shared, LONGEST_S)
    if not (np.ptp(a) > 0.0 and np.ptp(b) > 0.0):
        return 0
    most = min(max(1, int(LONGEST_S / float(np.median(np.diff(time))))), a.size // 3)
    lag, alike = best_lag(a, b, range(-most, most + 1))
    gain = np.sign(alike) * np.std(b) / np.std(a)
    a, b = gain * (a - np.median(a)), b - np.median(b)
    if not lag or abs(alike) <= ALIKE or float(np.std(a - b)) < APART * float(np.std(b)):
        return 0
    one, other = _servo(a, b), _servo(b, a)
    if max(one, other) < SERVO or abs(one - other) < CLEARER or (one > other) != (lag > 0):
        return 0
    return 1 if one > other else -1


def _servo(order: np.ndarray, rudder: np.ndarray) -> float:
    """Correlation of a rudder's movement with what was left to the order before it."""
    left = (order - rudder)[:-1]
    return cosine(left - np.median(left), np.diff(rudder))


def steps(first: ClockSeries, second: ClockSeries) -> int:
    """1 where the first series goes in steps and the second slews, -1 the other way round, 0 where neither; also for
    series of two clocks, whose lag says nothing."""
    shares = []
    for series in (first, second):
        values = known(series)[1]
        if values.size < FEWEST or not np.ptp(values) > 0.0:
            return 0
        shares.append((step_share(values), float(np.ptp(values))))
    (one, a), (two, b) = shares
    if not SAME_RANGE[0] < a / b < SAME_RANGE[1]:
        return 0
    if one > STEPPED and two < SLEWED:
        return 1
    return -1 if two > STEPPED and one < SLEWED else 0


def step_share(values: np.ndarray) -> float:
    """Share of the movement of values (N,) in single steps between samples at rest."""
    moved = np.abs(np.diff(values))
    beside = np.concatenate([[0.0], moved[:-1]]) + np.concatenate([moved[1:], [0.0]])
    single = (moved > 5.0 * beside) & (moved > LEAST_STEP * np.ptp(values))
    return float(moved[single].sum() / moved.sum()) if moved.sum() > 0.0 else 0.0
