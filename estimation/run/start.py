"""The state that a run starts from: smoothed from the record, and what that does not tell as the model has it there.

A record that begins in a turn without a measured sway would else start without drift, and the error that this leaves
for some ship lengths would look like one of the hull.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING

import numpy as np

from ...models.errors import CannotFit
from ...models.regimes import CLOCK
from ...models.time_scale import time_scale_s
from ..results.predictor import ModelPredictor

if TYPE_CHECKING:
    from ...models.model import Model

SLOW = ("u", "psi", "x", "y", CLOCK)
"""States that depend on more of the past than a few ship lengths and settle into nothing."""
STEP, STEPS = 0.1, 40
"""Time between two looks at a state that settles, in ship lengths sailed, and how many there are."""
SPAN = 3.0
"""Ship lengths sailed over which a start is fitted."""
ERRORS = {"u": 0.02, "r": 0.02, "psi": 0.01}
"""What the fitted states of a run may err by: shares of speed, of speed / length, rad."""
WIDTH, OF_SPEED, MOVE, ROUNDS = 0.2, 0.1, 0.02, 4
"""Prior standard deviation of a velocity about the steady one, and of the speed about that of the approach, step of
the differences (shares of the speed), rounds of the fit."""
TURNS = 0.1
"""Yaw rate, as a share of speed / length, from which a ship turns, and her speed is not that of the approach."""
MOST = 0.6
"""Share of the speed above which no sway is believed."""
TRIED = tuple(np.linspace(-0.36, 0.36, 13).tolist())
"""Sways, as shares of the speed, of which the best is where the fit begins: there may be several minima."""


def start_state(
    model: Model, approach: np.ndarray, known: Mapping[int, np.ndarray], inputs: np.ndarray, dt: float
) -> np.ndarray:
    """The state (n,) of a model where a record tells some of it: velocities that it does not tell are fitted to what it
    tells of the next SPAN ship lengths, about those into which the model settles while all else stays as it is; the
    speed where the ship turns, about that of the approach.

    approach : (n,) state on a straight course.  known : number of a state -> its values (K,) on the grid from there.
    inputs : (K, nu) there.
    """
    state = approach.copy()
    for number, values in known.items():
        state[number] = values[0]
    free = [i for i, name in enumerate(model.states) if i not in known and name not in SLOW]
    if not free or not known:
        return state
    try:
        scale_s = time_scale_s(model)
    except CannotFit:
        return state
    with np.errstate(all="ignore"):
        steady = _steady(model, state, free, inputs[0], scale_s)
        turns = "r" in model.states and abs(state[model.states.index("r")]) * scale_s > TURNS
        speed = [i for i, name in enumerate(model.states) if i not in known and name == "u"] if turns else []
        start = _fit(model, steady, [*free, *speed], known, inputs, dt, scale_s)
    return start if np.all(np.abs(start[free]) <= MOST * model.speed_m_s) else state


def _steady(model: Model, state: np.ndarray, free: Sequence[int], inputs: np.ndarray, scale_s: float) -> np.ndarray:
    """The state with the steady values of some of its elements; as it is where these do not."""
    predictor, held, now = ModelPredictor(model), np.tile(inputs, (2, 1)), state.copy()
    for _ in range(STEPS):
        now[free] = predictor.simulate(held, STEP * scale_s, now)[-1][free]
    return now if np.all(np.abs(now[free]) <= MOST * model.speed_m_s) else state


def _fit(
    model: Model,
    steady: np.ndarray,
    free: Sequence[int],
    known: Mapping[int, np.ndarray],
    inputs: np.ndarray,
    dt: float,
    scale_s: float,
) -> np.ndarray:
    """The state with some of its elements fitted by Gauss-Newton steps, under a prior about the steady one."""
    count = min(max(2, round(SPAN * scale_s / dt) + 1), len(inputs))
    unit = {"u": model.speed_m_s, "r": 1.0 / scale_s, "psi": 1.0}
    seen = {i: ERRORS[s] * unit[s] for i, s in enumerate(model.states) if i in known and s in ERRORS}
    weight = np.sqrt(SPAN / count)
    predictor, part = ModelPredictor(model), np.ascontiguousarray(inputs[:count])
    goal = np.column_stack([known[i][:count] for i in seen])
    sizes = np.array(list(seen.values()))

    def errors(state: np.ndarray) -> np.ndarray:
        run = predictor.simulate(part, dt, state)[:, list(seen)]
        return (weight * (goal - run) / sizes).ravel()

    move, places = MOVE * model.speed_m_s, list(free)
    prior = model.speed_m_s * np.array([OF_SPEED if model.states[i] == "u" else WIDTH for i in places])

    def cost(state: np.ndarray) -> float:
        error = errors(state)
        total = float(error @ error + np.sum(((state - steady)[places] / prior) ** 2))
        return total if np.isfinite(total) else np.inf

    now = min([steady, *_with_sways(model, steady, free)], key=cost)
    for _ in range(ROUNDS):
        base = errors(now)
        columns = np.column_stack([(base - errors(_with_change(now, i, move))) / move for i in places])
        if not (np.isfinite(base).all() and np.isfinite(columns).all()):
            break
        information = columns.T @ columns + np.diag(prior**-2.0)
        step = now.copy()
        step[places] += np.linalg.solve(information, columns.T @ base - (now - steady)[places] / prior**2)
        if not cost(step) < cost(now):
            break
        now = step
    return now


def _with_sways(model: Model, state: np.ndarray, free: Sequence[int]) -> list[np.ndarray]:
    """The state with each of the sways that are tried, where the sway is free."""
    sway = next((i for i in free if model.states[i] == "v"), None)
    if sway is None:
        return []
    return [_with_change(state, sway, share * model.speed_m_s - state[sway]) for share in TRIED]


def _with_change(state: np.ndarray, place: int, change: float) -> np.ndarray:
    out = state.copy()
    out[place] += change
    return out
