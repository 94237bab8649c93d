"""IMO manoeuvring indices of a record (MSC.137(76)), measured and simulated.

The simulated ship sails the same manoeuvre from the state that the record has at the first execute, with the recorded
rudder and revolutions.  In a zigzag it is given counter rudder when its own heading, not the recorded one, has changed
by as much as the recorded heading had when the recorded rudder was put over; the rudder then moves as recorded.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence

import numpy as np

from ...datasets.columns import RUDDERS
from ...datasets.indices import (
    OVERSHOOTS,
    TURNING,
    RecordedManoeuvre,
    heading_extremes,
    initial_turning,
    turning_indices,
    without_gaps,
)
from ...datasets.record import Record
from ..run.run import as_shown
from ..run.stretch import Stretch
from .result import Index

IndexValues = tuple[Mapping[str, float], Mapping[str, str]]
"""Values by index name, rad or m, and why there is none by index name."""
INITIAL = "initial_turning"
UNITS: dict[str, str] = {**dict.fromkeys(OVERSHOOTS, "rad"), **dict.fromkeys((INITIAL, *TURNING), "m")}
INITIAL_RUDDER_RAD = math.radians(9.0), math.radians(11.0)
"""Rudder angles for which the initial turning ability is told; it is defined for 10 degrees."""
POSITIONS, VELOCITIES = ("north_m", "east_m"), ("surge_m_s", "sway_m_s")
LONGER = 2
"""A simulated manoeuvre may take so many times the duration of the recorded one."""


def names_of(found: RecordedManoeuvre) -> tuple[str, ...]:
    """The indices that a manoeuvre has."""
    low, high = INITIAL_RUDDER_RAD
    reaches = found.kind == "turn" or found.heading_rad >= low
    initial = (INITIAL,) if reaches and low <= found.rudder_rad <= high else ()
    return (*(OVERSHOOTS if found.kind == "zigzag" else TURNING), *initial)


def measured_indices(record: Record, found: RecordedManoeuvre) -> IndexValues:
    """The indices of a recorded manoeuvre, with reasons for those that the record does not allow."""
    first = found.executes[0]
    return _indices(record.slice(first, None), found, [mark - first for mark in found.executes], "the record")


def simulated_indices(stretch: Stretch, record: Record, found: RecordedManoeuvre) -> IndexValues:
    """The same indices of the simulated manoeuvre.

    Parameters
    ----------
    stretch : the model on what the hull did.
    record : the samples that it comes from, as they were recorded, in the model's rudder sign.
    """
    if "psi" not in stretch.model.states:
        return {}, dict.fromkeys(names_of(found), "the model has no heading")
    places = (record.time_s[list(found.executes)] - stretch.grid_s[0]) / stretch.series.dt
    marks = np.rint(places).astype(int).tolist()
    source, states, orders, early = sail(stretch, marks, not record.has(RUDDERS[1]))
    values, reasons = _indices(_shown(stretch, record, source, states), found, orders, "the model")
    return values, {name: early or reason for name, reason in reasons.items()}


def rows(
    model: str, record: str, length_m: float, found: RecordedManoeuvre, measured: IndexValues, simulated: IndexValues
) -> list[Index]:
    """A row an index."""
    out = []
    for name in names_of(found):
        reasons = dict.fromkeys(why[name] for _, why in (measured, simulated) if why.get(name))
        real, own = (values.get(name, math.nan) for values, _ in (measured, simulated))
        out.append(Index(model, record, found.title, name, UNITS[name], real, own, "; ".join(reasons), length_m))
    return out


def sail(stretch: Stretch, marks: Sequence[int], leaves_late: bool) -> tuple[np.ndarray, np.ndarray, list[int], str]:
    """The manoeuvre with rudder orders at the grid points `marks` of the recorded one, sailed by the model.

    leaves_late : whether the rudder still has its old angle at a mark (a measured one has).

    Returns
    -------
    Grid numbers of the recorded inputs in turn, from the first execute on, states, numbers of the rudder orders in it,
    and why it ends early, or an empty text.
    """
    inputs, first, psi = stretch.series.inputs, marks[0], stretch.model.states.index("psi")
    heading, start = stretch.known[psi], stretch.state_at(first)
    ends = [*(mark - (not leaves_late) for mark in marks[1:]), len(inputs) - 1]
    length = LONGER * (len(inputs) - first)
    source, orders, reason = np.zeros(0, int), [0], ""
    for place, mark in enumerate(marks[: len(OVERSHOOTS) + 1]):
        leg = np.minimum(mark + np.arange(length - orders[-1]), ends[place])
        source = np.concatenate([source[: orders[-1]], leg])
        run = stretch.run(start, inputs[source])
        if place == min(len(OVERSHOOTS), len(marks) - 1):
            break
        goal = float(heading[marks[place + 1]])
        side = 1.0 if goal >= heading[mark] else -1.0
        order = _reached(run.states[:, psi], side, goal - float(heading[first]), orders[-1])
        if order is None:
            reason = f"the simulated heading does not change by {math.degrees(goal - heading[first]):.3g} deg"
            break
        orders.append(order)
    if run.diverged_s is not None:
        reason = f"the simulation diverged after {run.diverged_s:.3g} s"
    return source, run.states, orders, reason


def _reached(heading: np.ndarray, side: float, change: float, after: int) -> int | None:
    """The sample behind `after` that is nearest to where the heading (N,) has changed by `change` towards `side`."""
    short = side * (change - (heading - heading[0]))
    step = np.abs(np.diff(heading, append=heading[-1]))
    there = np.flatnonzero(short[after + 1 :] <= 0.5 * step[after + 1 :])
    return after + 1 + int(there[0]) if there.size else None


def _shown(stretch: Stretch, record: Record, source: np.ndarray, states: np.ndarray) -> Record:
    """The simulated manoeuvre as the model's instruments show it."""
    time = stretch.series.dt * np.arange(len(source))
    even = Record(time, {"rudder_rad": stretch.series.inputs[source, 0]}, record.name, record.meta)
    return as_shown(stretch.model, even, stretch.channels(states))


def _indices(record: Record, found: RecordedManoeuvre, orders: Sequence[int], whose: str) -> IndexValues:
    """Indices of a manoeuvre that starts with its first execute."""
    known = {name: v for name, v in record.channels.items() if np.isfinite(v).any()}
    whole = record.with_channels(
        **{name: without_gaps(values) for name, values in known.items() if name not in RUDDERS}
    )
    absent = {name: None for name in record.channels if name not in known}
    whole = whole.with_channels(**absent, heading_rad=without_gaps(record.heading_unwrapped()))
    values = {name: math.nan for name in names_of(found)}
    reasons = dict.fromkeys(names_of(found), f"{whose} ends before")
    if found.kind == "zigzag":
        heading = whole.column("heading_rad")
        passed = heading_extremes(heading, orders) if len(orders) > 1 else []
        values |= dict(zip(OVERSHOOTS, (abs(float(heading[b] - heading[a])) for a, b in passed), strict=False))
    elif whole.has(*POSITIONS):
        turned = turning_indices(whole, float(whole.time_s[0]))
        values |= {name: turned[name] for name in TURNING}
    else:
        reasons |= dict.fromkeys(TURNING, f"{whose} has no positions")
    if INITIAL in values:
        tracked = whole.has(*POSITIONS) or whole.has(*VELOCITIES)
        values[INITIAL] = initial_turning(whole, float(whole.time_s[0])) if tracked else math.nan
        reasons |= {} if tracked else {INITIAL: f"{whose} has neither positions nor velocities"}
    return values, {name: reasons[name] for name, value in values.items() if not math.isfinite(value)}
