"""Manoeuvring indices of many simulated runs at once; the definitions are those of `datasets.indices`."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from .indices import OVERSHOOTS, TURNING, execute_times, initial_turning, turning_indices
from .record import Record

INITIAL = "initial_turning"
STEADY = {"steady_radius": "m", "steady_speed": "m/s", "steady_yaw_rate": "rad/s"}
INDICES: dict[str, str] = {**dict.fromkeys(OVERSHOOTS, "rad"), **dict.fromkeys((*TURNING, INITIAL), "m"), **STEADY}
"""Name -> unit."""


def indices(names: Sequence[str], time_s: np.ndarray, channels: Mapping[str, np.ndarray]) -> dict[str, np.ndarray]:
    """Index name -> (W,) of noise-free runs with channels (W, N+1) at times (N+1,); nan where not reached."""
    found: dict[str, np.ndarray] = {}
    if set(names) & set(OVERSHOOTS):
        angles = overshoots(channels["rudder_command_rad"], channels["heading_rad"], len(OVERSHOOTS))
        found = dict(zip(OVERSHOOTS, angles, strict=True))
    others = [name for name in names if name not in OVERSHOOTS]
    found |= _of_runs(others, time_s, channels) if others else {}
    return {name: found[name] for name in names}


def overshoots(order: np.ndarray, heading: np.ndarray, count: int) -> np.ndarray:
    """The first overshoot angles (count, W) of zigzags whose orders and headings are (W, N+1), rad.

    nan where the record ends before the heading turns.
    """
    side = np.sign(order)
    reversals = np.cumsum(side[:, 1:] * side[:, :-1] < 0.0, axis=1)
    out, rows, last = np.full((count, len(order)), np.nan), np.arange(len(order)), order.shape[1] - 1
    for number in range(1, count + 1):
        reversed_at = (reversals == number).argmax(axis=1) + 1
        within = np.zeros(order.shape, dtype=bool)
        within[:, 1:] = reversals == number
        base = heading[rows, reversed_at]
        swing = np.where(base >= heading[:, 0], 1.0, -1.0)
        beyond = np.where(within, swing[:, None] * (heading - base[:, None]), -np.inf)
        at = beyond.argmax(axis=1)
        passed = (reversals[:, -1] >= number) & (at < last)
        out[number - 1] = np.where(passed, beyond[rows, at], np.nan)
    return out


def _of_runs(names: Sequence[str], time_s: np.ndarray, channels: Mapping[str, np.ndarray]) -> dict[str, np.ndarray]:
    """Indices that are found run by run, of turning circles and initial turning; nan where the rudder never moves."""
    out = {name: np.full(len(channels["rudder_rad"]), np.nan) for name in names}
    for i in np.flatnonzero(np.abs(channels["rudder_rad"]).max(axis=1) > 0.0).tolist():
        run = {name: values[i] for name, values in channels.items()}
        if np.isfinite(run["heading_rad"]).all():
            record = Record(time_s, run)
            found = turning_indices(record) if set(names) - {INITIAL} else {}
            if INITIAL in names:
                found[INITIAL] = initial_turning(record, float(execute_times(record)[0]))
            for name in names:
                out[name][i] = found[name]
    return out
