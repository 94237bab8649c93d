"""Simulation of many runs of one model at once, in blocks of `width(model)` runs that advance together.

Runs differ in coefficients, initial states, inputs, helmsmen and weather.  Sine, cosine, exponential and arc tangent of
a block are polynomials (2e-15 of the value), and sums may be taken in another order: states agree with `simulate` and
`closed_loop` to 1e-11 of their largest value, not bit for bit.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from . import lane_drivers
from .errors import BadInput
from .instruments import linkage
from .kernels import Kernels
from .model import Model
from .regimes import Regime
from .simulate import (
    KINDS,
    ClosedLoop,
    closed_loop,
    gates_of,
    initial_state,
    inputs_of,
    places_of,
    setting_of,
    substeps,
    variant,
)

Array = NDArray[np.float64]
LINE = 64
"""Bytes of a line of the processor's cache."""


@dataclass(frozen=True)
class Runs:
    """W simulated manoeuvres: states (W, N+1, n), rudder command and rudder (W, N+1) rad."""

    states: Array
    command_rad: Array
    rudder_rad: Array


def width(model: Model) -> int:
    """Largest number of runs of a block."""
    return int(model.kernels.LANES)


def open_loops(
    model: Model,
    coefficients: ArrayLike,
    inputs: ArrayLike,
    dt: float,
    x0: ArrayLike,
    inside: ArrayLike | None = None,
    regimes: Sequence[Regime] = (),
) -> Array:
    """States (B, N+1, n) of B runs: coefficients (B, p), inputs (B, N+1, nu), linear between samples, x0 (B, n).

    coefficients : or all numbers (B, p + c), where the runs differ in the model's constants too.
    inputs : or with the 7 columns of the environment variant behind the model's own; of a response model one, a yaw
        acceleration from outside.
    inside : coefficients in a regime of each run, whose time is that from the first sample.
    """
    u, start, sets = _runs(inputs, 3), _runs(x0, 2), _runs(coefficients, 2)
    lanes, count, samples = width(model), substeps(model, dt), u.shape[1]
    kernels, whole = variant(model, u.shape[2], model.theta)
    outside = np.repeat(whole[model.theta.size :], lanes)
    states = np.empty((len(u), samples, start.shape[1]))
    within = None if inside is None else _runs(inside, 2)
    gates, where = gates_of(regimes), places_of(kernels.STATES)
    series, work = _aligned(samples * u.shape[2] * lanes).reshape(samples, -1), _work(kernels, u.shape[2])
    for first in range(0, len(u), lanes):
        pick = slice(first, first + lanes)
        if first + lanes > len(u):
            pick = np.minimum(np.arange(first, first + lanes), len(u) - 1)
        series.reshape(samples, -1, lanes)[:] = u[pick].transpose(1, 2, 0)
        numbers, begin = _numbers(kernels, _theta(model, sets[pick]), outside), start[pick].T.ravel()
        block = states[first : first + lanes]
        if within is None:
            lane_drivers.open_loop(kernels.rhs_lanes, begin, series, numbers, dt, count, work, block)
            continue
        other = _numbers(kernels, _theta(model, within[pick]), outside)
        lane_drivers.in_regimes(kernels.rhs_lanes, begin, series, numbers, other, gates[pick], where, dt, count, block)
    return states


def closed_loops(
    model: Model,
    dt: float,
    controls: Sequence[ClosedLoop],
    coefficients: ArrayLike | None = None,
    x0: ArrayLike | None = None,
    environment: ArrayLike | None = None,
    integrator: str = "rk4",
) -> Runs:
    """As `simulate.closed_loop`, for at most `width(model)` runs at once whose controls are equally long.

    Parameters
    ----------
    coefficients : (W, p), or the model's own for all.
    x0 : initial states (W, n), or the straight course at the model's speed.
    environment : (W, N+1, 7) as in `simulate.closed_loop`; 3-DOF models only.

    A model whose rudder linkage is not ideal is simulated run by run: blocks do not hold what a linkage remembers.

    Raises
    ------
    BadInput : more runs than a block holds, or no windage data in wind.
    """
    runs, lanes, samples = len(controls), width(model), len(controls[0].reference)
    if runs > lanes:
        raise BadInput(f"{runs} runs in a block of {lanes}")
    pick = np.minimum(np.arange(lanes), runs - 1)
    steered = [controls[i] for i in pick]
    sets = _spread(model.coefficients if coefficients is None else coefficients, runs)[pick]
    start = _spread(initial_state(model) if x0 is None else x0, runs)[pick]
    if linkage(model.instruments).any():
        return _one_by_one(model, dt, controls, sets[:runs], start[:runs], environment, integrator)
    inputs = np.repeat(inputs_of(model, np.zeros(samples)), lanes, axis=1)
    kernels, outside = model.kernels, np.empty(0)
    if environment is not None and np.any(environment):
        weather = _runs(environment, 3)
        inputs = np.hstack([inputs, weather[pick].transpose(1, 2, 0).reshape(samples, -1)])
        kernels, whole = model.environment(wind=bool(np.any(weather[..., 2:4])))
        outside = np.repeat(whole[model.theta.size :], lanes)
    numbers = _numbers(kernels, _theta(model, sets), outside)
    states = np.empty((samples, start.shape[1] * lanes))
    order, rudder = np.empty((samples, lanes)), np.empty((samples, lanes))
    lane_drivers.closed_loop(
        kernels.rhs_lanes, start.T.ravel(), np.ascontiguousarray(inputs), numbers, dt, substeps(model, dt),
        integrator == "euler", np.array([KINDS.index(control.kind) for control in steered]),
        np.column_stack([control.reference for control in steered]),
        np.column_stack([setting_of(control) for control in steered]),
        model.states.index("psi"), model.states.index("r"), _work(kernels, len(kernels.INPUTS)), states, order, rudder,
    )  # fmt: skip
    by_run = states.reshape(samples, -1, lanes).transpose(2, 0, 1)
    return Runs(by_run[:runs], order.T[:runs], rudder.T[:runs])


def _one_by_one(
    model: Model,
    dt: float,
    controls: Sequence[ClosedLoop],
    sets: Array,
    x0: Array,
    environment: ArrayLike | None,
    integrator: str,
) -> Runs:
    weather = [None] * len(controls) if environment is None else _runs(environment, 3)
    own = [model.with_coefficients(c) for c in sets]
    runs = [closed_loop(*run, integrator) for run in zip(own, [dt] * len(own), controls, weather, x0, strict=True)]
    return Runs(*(np.array([getattr(run, name) for run in runs]) for name in ("states", "command_rad", "rudder_rad")))


def _theta(model: Model, sets: Array) -> Array:
    """Coefficients (W, p) and the model's constants, or all numbers (W, p + c), as the kernels take them."""
    if sets.shape[1] == model.theta.size:
        return sets.T.ravel()
    return np.hstack([sets, np.tile(model.constants, (len(sets), 1))]).T.ravel()


def _numbers(kernels: Kernels, theta: Array, outside: Array) -> Array:
    """The values that `rhs_lanes` takes, from the models' numbers and those of what is outside."""
    numbers = _aligned(kernels.LANE_NUMBERS * kernels.LANES)
    kernels.prepare_lanes(np.concatenate([theta, outside]), numbers)
    return numbers


def _work(kernels: Kernels, inputs: int) -> Array:
    """Working space of the drivers for a block with that many inputs a run."""
    return _aligned((6 * len(kernels.STATES) + inputs) * kernels.LANES)


def _aligned(size: int) -> Array:
    """An array (size,) that begins with a line of the processor's cache: a vector of a block lies in one line."""
    room = np.empty(size + LINE // 8 - 1)
    first = -room.ctypes.data % LINE // 8
    return room[first : first + size]


def _spread(values: ArrayLike, runs: int) -> Array:
    array = np.asarray(values, float)
    return np.broadcast_to(array, (runs, array.shape[-1]))


def _runs(values: ArrayLike, dimensions: int) -> Array:
    array = np.asarray(values, float)
    if array.ndim != dimensions:
        raise BadInput(f"an array of {dimensions} dimensions is needed, not {array.ndim}")
    return array
