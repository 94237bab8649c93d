"""Two fixed propellers that steer a craft without a rudder: their pair is told by names and by the yaw rate."""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import dataclass, replace
from itertools import combinations

import numpy as np

from .beside import of_side
from .draft import NOT_USED, Answer, Question
from .evidence import ClockSeries, together
from .finding import ColumnFinding, line_of
from .log import RawLog
from .no_rudder import PROPELLERS, is_unsteered, response
from .quantities import word_list
from .units import UNITS, unit_of

PORT, STARBOARD = "thrust_port", "thrust_starboard"
PULSE_US, NEUTRAL_US = (700.0, 2300.0), 1500.0
MOST = 24
"""Columns without a name of a side above which pairs are not tried."""


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


def settle(log: RawLog) -> None:
    """Make two columns the thrusts to port and starboard where a craft has no rudder, or ask which ones they are."""
    if not is_unsteered({quantity for f in log.findings for quantity in f.may_be}):
        return
    pairs = list(_pairs(log))
    if PROPELLERS in log.answers:
        _as_answered(log, pairs, log.answers[PROPELLERS])
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
        _use(log, best.port, best.starboard, why)
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
    if one is None or two is None:
        return _Pair(port, starboard, sided, None, False)
    shared = together(one, two)
    if shared is None:
        return _Pair(port, starboard, sided, None, False)
    difference = ClockSeries(shared[0], shared[1] - shared[2], one.clock, one.dated)
    for signed in (True, False):
        for _, rate in log.all("yaw_rate", signed=signed):
            share = response(difference, rate)
            if share is not None:
                return _Pair(port, starboard, sided, share, signed)
    return _Pair(port, starboard, sided, None, False)


def _use(log: RawLog, port: int, starboard: int, why: str) -> None:
    for place, quantity in ((port, PORT), (starboard, STARBOARD)):
        found = log.findings[place]
        stated = unit_of(found.column.unit, "force") or (UNITS["kN"] if found.column.name.endswith("kN") else None)
        newtons = stated is not None or _named_force(found)
        told = why if newtons else f"{why}; in the file's own unit, one of it counts as 1 N"
        log.findings[place] = replace(
            found, may_be=(quantity,), unit=stated or UNITS["N"], factor=1.0, offset=_offset(found), sign=1,
            signed=True, questions=(), sure="stated" if newtons else "guess", why=(told,),
        )  # fmt: skip


def _offset(found: ColumnFinding) -> float:
    """What is added to a servo's pulse, which is 1500 us at rest."""
    known = found.column.finite
    pulse = PULSE_US[0] <= known.min() and known.max() <= PULSE_US[1] and known.max() > 1000.0
    return -NEUTRAL_US if pulse else 0.0


def _as_answered(log: RawLog, pairs: list[_Pair], key: str) -> None:
    if key == NOT_USED:
        return
    for pair in pairs:
        for port, starboard in ((pair.port, pair.starboard), (pair.starboard, pair.port)):
            if key == _key(log, port, starboard):
                _use(log, port, starboard, "as answered")
                return


def _key(log: RawLog, port: int, starboard: int) -> str:
    return f"{log.findings[port].column.name}, {log.findings[starboard].column.name}"


def _question(log: RawLog, pairs: list[_Pair], against: bool) -> Question:
    ordered = sorted(pairs, key=lambda pair: (not pair.sided, -abs(pair.share or 0.0)))[:4]
    answers = []
    for pair in ordered:
        ways = [(pair.port, pair.starboard), (pair.starboard, pair.port)]
        turned = pair.signed and pair.share is not None and pair.share < 0.0
        answers += [_answer(log, *way) for way in (reversed(ways) if turned else ways)]
    first = log.findings[ordered[0].port]
    names = " and ".join(log.findings[i].column.name for i in (ordered[0].port, ordered[0].starboard))
    text = f"There is no rudder: do the two propellers {names} steer the craft, and which one is on the port side?"
    text += " The yaw rate answers them the other way round than their names say." if against else ""
    none = Answer(NOT_USED, "none of them is used", line_of(first, to=NOT_USED))
    return Question(PROPELLERS, "quantity", first.table.label, first.column.name, text, (*answers, none))


def _answer(log: RawLog, port: int, starboard: int) -> Answer:
    one, two = log.findings[port], log.findings[starboard]
    text = f"{one.column.name} to port, {two.column.name} to starboard; their difference steers, their mean drives"
    lines = [
        line_of(replace(f, factor=1.0, offset=_offset(f), sign=1), to=quantity, unit="N")
        for f, quantity in ((one, PORT), (two, STARBOARD))
    ]
    return Answer(_key(log, port, starboard), text, "\n".join(lines))
