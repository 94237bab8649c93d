"""Order and answer of a rudder: of two columns that move alike the earlier one is the order, whatever the names."""

from __future__ import annotations

from dataclasses import replace
from itertools import combinations

import numpy as np

from .evidence import FEWEST, ClockSeries, best_lag, cosine, known, liveliest, together
from .finding import WITH_SIDE, ColumnFinding, ask_quantity
from .log import RawLog
from .names import words

RUDDER, ORDER = WITH_SIDE
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


def settle(log: RawLog) -> None:
    """Make the earlier of two rudders the order and the later one the rudder; ask where a name says the opposite."""
    able = [i for i, found in enumerate(log.findings) if _may_steer(found)]
    for i, j in combinations(able, 2):
        one, two = log.findings[i], log.findings[j]
        if not (_may_steer(one) and _may_steer(two)):  # an earlier pair may have settled it
            continue
        lead = leader(log, one, two)
        if lead:
            first, then = (i, j) if lead > 0 else (j, i)
            _assign(log, first, then)


def _may_steer(found: ColumnFinding) -> bool:
    rudder = bool(found.may_be) and set(found.may_be) <= set(WITH_SIDE) and found.column.numeric
    return rudder and not set(words(found.column.name)) & SMOOTHED


def _assign(log: RawLog, first: int, then: int) -> None:
    order, rudder = log.findings[first], log.findings[then]
    if order.may_be == rudder.may_be == (ORDER,):  # an order and what limits it
        return
    if "quantity" in (*order.bounded, *rudder.bounded):
        return
    if rudder.may_be == (ORDER,) and order.may_be != (ORDER,):
        log.findings[first], log.findings[then] = _asked(log, order, rudder)
        return
    log.findings[first] = _as(order, ORDER, f"the order: column {rudder.column.name} follows it")
    log.findings[then] = _as(rudder, RUDDER, f"the answer: it follows column {order.column.name}")


def _as(found: ColumnFinding, quantity: str, why: str) -> ColumnFinding:
    """A column in its role; a doubt about its name is settled by that."""
    if found.may_be == (quantity,) and not any(q.about == "quantity" for q in found.questions):
        return found if why in found.why else replace(found, why=(*found.why, why))
    kept = tuple(q for q in found.questions if q.about != "quantity")
    sure = "other channel" if found.sure == "guess" and not kept else found.sure
    found = replace(found, questions=kept, sure=sure)
    return found.told("other channel", why, may_be=(quantity,), signed=quantity == RUDDER)


def _asked(log: RawLog, order: ColumnFinding, rudder: ColumnFinding) -> tuple[ColumnFinding, ColumnFinding]:
    """An earlier and a later column whose names say the opposite, with the question which one is the order."""
    text = (
        f"{rudder.column.name!r} is called an order, and it follows {order.column.name!r}: is it the rudder, "
        f"and {order.column.name!r} the order?"
    )
    settled = log.answered(ask_quantity(rudder, text, (RUDDER, ORDER)))
    if settled.questions or not settled.may_be:
        return order, settled
    other = ORDER if settled.quantity == RUDDER else RUDDER
    signed = replace(settled, signed=settled.quantity == RUDDER)
    return replace(order, may_be=(other,), signed=other == RUDDER, bounded=(*order.bounded, "quantity")), signed


# ------------------------------------------------------------------------------------------------ which is earlier


def leader(log: RawLog, one: ColumnFinding, two: ColumnFinding) -> int:
    """1 where the first column is the order of the second, -1 the other way round, 0 where nothing tells it."""
    first, second = log.series(one, raw=True), log.series(two, raw=True)
    return lead(first, second) if first is not None and second is not None else 0


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
