"""Simulation, sensitivities and regressors of a model, in NumPy arrays.

N+1 samples, n states, nu inputs, p coefficients.  Inputs are linear between samples unless held; the integrator is
RK4 with a fixed step of at most `model.max_step_s`.  A diverging run gives non-finite rows; nothing raises for it.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache
from math import ceil

import numpy as np
from numpy.typing import ArrayLike, NDArray

from . import kernels as kernel_store
from .errors import BadInput
from .instruments import linkage
from .model import Model, RudderGear
from .regimes import VARIABLES, Regime

STABLE, DIFFERENCE = 1.0, 1e-6
"""Product of a step of RK4 and the fastest eigenvalue (beyond 2.8 a run diverges), and the step of differences."""
KINDS = ("series", "zigzag", "heading")
MOST_SUBSTEPS = 10_000
"""Integration steps within a sample beyond which a simulation is refused: it would not end."""


@dataclass(frozen=True)
class ClosedLoop:
    """What steers the ship: a rudder series, a zigzag, or the model's heading controller.

    Parameters
    ----------
    kind : 'series' (``reference`` is the rudder command, rad), 'zigzag', or 'heading' (``reference`` is the heading
        to follow, rad).
    reference : (N+1,) array; for a zigzag only its length counts.
    gear : lag, rate limit and largest angle of the rudder.
    execute_s : when the first rudder order of a zigzag is given.
    rudder_rad, heading_rad : the zigzag's pair; the rudder angle that turns the ship to starboard is
        ``rudder_rad`` (negative for a model whose positive rudder turns to port).
    first : +1 if the first order is to starboard, -1 if to port.
    kp, kd : gains of the heading controller, delta = kp (reference - psi) - kd r.
    """

    kind: str
    reference: NDArray[np.float64]
    gear: RudderGear
    execute_s: float = 0.0
    rudder_rad: float = 0.0
    heading_rad: float = 0.0
    first: int = 1
    kp: float = 0.0
    kd: float = 0.0


@dataclass(frozen=True)
class SimulatedRun:
    """A simulated manoeuvre: time (N+1,) s, states (N+1, n), rudder command and rudder (N+1,) rad."""

    time_s: NDArray[np.float64]
    states: NDArray[np.float64]
    command_rad: NDArray[np.float64]
    rudder_rad: NDArray[np.float64]


def substeps(model: Model, dt: float) -> int:
    """Integration steps per sample of dt seconds; BadInput where there are more than any ship needs."""
    count = dt / model.max_step_s
    if not count <= MOST_SUBSTEPS:
        message = f"{model.id}: a largest step of {model.max_step_s:g} s makes {count:.3g} steps a sample of {dt:g} s"
        raise BadInput(message, hint=f"at most {MOST_SUBSTEPS} are taken: raise max_step_s or sample faster")
    return max(1, ceil(count - 1e-9))


def initial_state(model: Model) -> NDArray[np.float64]:
    """The state (n,) of a straight course at the model's speed."""
    x = np.zeros(len(model.states))
    if "u" in model.states:
        x[model.states.index("u")] = model.speed_m_s
    return x


def inputs_of(model: Model, rudder: ArrayLike, propeller: ArrayLike | None = None) -> NDArray[np.float64]:
    """Input array (N, nu) from the rudder angle (N,) and, where the model takes it, the propeller [1/s].

    Without it the model's own propeller setting is held, and its speed.
    """
    rudder = np.asarray(rudder, float)
    given = {
        "delta": rudder,
        "n": model.n0_rps if propeller is None else propeller,
        "speed": model.speed_m_s,
        "thrust_sum": 0.0,
        "wind_north": 0.0,
        "wind_east": 0.0,
    }
    columns = [np.broadcast_to(np.asarray(given[name], float), rudder.shape) for name in model.inputs]
    return np.ascontiguousarray(np.column_stack(columns))


def variant(model: Model, width: int, theta: NDArray[np.float64]) -> tuple[kernel_store.Kernels, NDArray[np.float64]]:
    """Kernels and parameter vector for inputs of `width` columns: those of the environment variant for 7 more, of a
    response model those with a yaw acceleration from outside for one more.

    theta : the model's own (p + c,), or already that of the variant.
    """
    if width == len(model.inputs):
        return model.kernels, theta[: model.theta.size]
    if not model.is_3dof and width == len(model.inputs) + 1:
        return kernel_store.load(model.family + kernel_store.PUSHED), theta
    kernels, whole = model.environment(wind=model.windage is not None)
    return kernels, np.concatenate([theta, whole[theta.size :]])


def simulate(
    model: Model, inputs: ArrayLike, dt: float, x0: ArrayLike, *, hold: str = "linear", integrator: str = "rk4"
) -> NDArray[np.float64]:
    """States (N+1, n) driven by inputs (N+1, nu) sampled every dt seconds.

    Parameters
    ----------
    inputs : the model's; or 7 more columns, those of its environment variant (current, wind, forces).
    hold : 'linear' or 'zero', the input between samples.
    integrator : 'rk4', or 'euler': one explicit step a sample with the input held, which is the difference
        equation that forward-difference least squares inverts.
    """
    from . import drivers

    u, start = _array(inputs, 2), _array(x0, 1)
    if u.shape[1] > len(model.inputs) and model.windage is None:
        model.environment(wind=bool(np.any(u[:, -5:-3])))  # refuses wind
    states = np.empty((len(u), start.size))
    kernels, theta = variant(model, u.shape[1], model.theta)
    if integrator == "euler":
        drivers.euler(kernels.rhs, start, u, theta, dt, states)
    else:
        count = substeps(model, dt)
        kernels.simulate(start, u, theta, dt / count, count, hold == "zero", states)
    return states


def sensitivities(
    model: Model,
    inputs: ArrayLike,
    dt: float,
    x0: ArrayLike,
    columns: Sequence[int] | None = None,
    initial: Sequence[int] = (),
    *,
    seed: NDArray[np.float64] | None = None,
    hold: str = "linear",
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """States (N+1, n) and their derivatives (N+1, n, m) by forward sensitivities.

    The m columns are the chosen coefficients (default: all), then the chosen elements of the initial state.

    seed : derivatives (n, m) of the initial state; None: of a state that the coefficients do not determine.
    """
    from . import drivers

    u, start = _array(inputs, 2), _array(x0, 1)
    chosen = list(range(len(model.coordinates))) if columns is None else list(columns)
    source, target, sparse = tangent_tables(model, chosen, len(initial))
    n, m = start.size, len(chosen) + len(initial)
    if seed is None:
        seed = np.zeros((n, m))
        seed[list(initial), len(chosen) + np.arange(len(initial))] = 1.0
    states, flat = np.empty((len(u), n)), np.empty((len(u), n * m))
    drivers.sensitivities(
        model.kernels.tangent, start, u, model.theta, dt, substeps(model, dt), hold == "zero",
        source, target, sparse, seed.ravel(), states, flat,
    )  # fmt: skip
    return states, flat.reshape(len(u), n, m)


def tangent_tables(model: Model, columns: Sequence[int], extra: int = 0):
    """Index tables for `drivers.tangent_sample`: which sparse value of df/dc goes to which sensitivity element.

    Returns source, target (int64 arrays, not to be changed) and the number of sparse values; the column stride is
    ``len(columns) + extra``.
    """
    return _tangent_tables(model.kernels, tuple(columns), extra)


@lru_cache(maxsize=64)
def _tangent_tables(kernels: kernel_store.Kernels, columns: tuple[int, ...], extra: int):
    place = {column: index for index, column in enumerate(columns)}
    stride = len(columns) + extra
    pairs = [
        (k, row * stride + place[column])
        for k, (column, row) in enumerate(zip(kernels.JT_COLUMN.tolist(), kernels.JT_ROW.tolist(), strict=True))
        if column in place
    ]
    source, target = (np.array([pair[i] for pair in pairs], dtype=np.int64) for i in range(2))
    return source, target, kernels.JT_COLUMN.size


def step_map(
    model: Model, states: ArrayLike, inputs: ArrayLike, dt: float, theta: ArrayLike | None = None
) -> NDArray[np.float64]:
    """One-sample predictions (N, n) from each row of states (N, n), with inputs (N+1, nu).

    inputs : or with those of the environment, as in `variant`.  theta (p + c,) : numbers of the model; None: its own.
    """
    from . import drivers

    x, u = _array(states, 2), _array(inputs, 2)
    kernels, numbers = variant(model, u.shape[1], model.theta if theta is None else _array(theta, 1))
    ahead = np.empty_like(x)
    drivers.one_step(kernels.rhs, x, u, numbers, dt, substeps(model, dt), ahead)
    return ahead


def slopes_along(
    model: Model, theta: ArrayLike, states: ArrayLike, inputs: ArrayLike, dt: float
) -> NDArray[np.float64]:
    """Slopes (N, n, n) of the state one sample ahead by the state along a run.

    theta (p + c,) : numbers of the model.  states (N+1, n), inputs (N+1, nu) : as in `simulate`.
    """
    here, slopes = _array(states, 2)[:-1], []
    base = step_map(model, here, inputs, dt, theta)
    for i, step in enumerate((DIFFERENCE * (1.0 + np.max(np.abs(here), axis=0))).tolist()):
        other = here.copy()
        other[:, i] += step
        slopes.append((step_map(model, other, inputs, dt, theta) - base) / step)
    return np.stack(slopes, axis=2)


def changes_along(
    model: Model,
    theta: ArrayLike,
    states: ArrayLike,
    inputs: ArrayLike,
    dt: float,
    changes: Sequence[tuple[NDArray[np.float64], NDArray[np.float64]]],
) -> list[NDArray[np.float64]]:
    """Changes (N, n) of the state one sample ahead along a run, by changes that each act on the whole sample.

    theta, states, inputs : as of `slopes_along`.  changes : of the inputs (nu,), and of the numbers (p + c,).
    """
    here, u, numbers = _array(states, 2)[:-1], _array(inputs, 2), _array(theta, 1)
    base = step_map(model, here, u, dt, numbers)
    return [step_map(model, here, u + of_inputs, dt, numbers + own) - base for of_inputs, own in changes]


def regression(
    model: Model, states: ArrayLike, accelerations: ArrayLike, inputs: ArrayLike
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """y (N, k) and Phi (N, k, p) with y = Phi @ coefficients, from states in `model.regression_states` order.

    The first k regression states have the given accelerations (N, k); inputs are in `model.regression_inputs`
    order (a second-order response model also needs the rudder's derivative).
    """
    from . import drivers

    x, a, u = _array(states, 2), _array(accelerations, 2), _array(inputs, 2)
    rows, count = a.shape[1], len(model.coordinates)
    left, right = np.empty((len(x), rows)), np.empty((len(x), rows * count))
    drivers.regressors(model.kernels.regress, x, a, u, model.theta, left, right)
    return left, right.reshape(len(x), rows, count)


def simulated_states(model: Model, states: ArrayLike, rudder: ArrayLike) -> NDArray[np.float64]:
    """Regression states (N, n) turned into simulated ones: w = q - c delta for second-order response models."""
    x = np.array(states, float)
    gain = model.kernels.RATE_GAIN
    if gain is not None:
        x[:, 0] -= model.coefficients[gain] * np.asarray(rudder, float)
    return x


def zoh_matrices(model: Model, dt: float) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Exact A_d (n, n), B_d (n, nu) of a linear model for an input held over dt seconds.

    Raises
    ------
    ValueError : if the model is not linear.
    """
    from scipy.linalg import expm

    if not model.is_linear:
        raise ValueError(f"{model.id} is not a linear model")
    a, b = state_matrices(model)
    n, nu = b.shape
    block = np.zeros((n + nu, n + nu))
    block[:n, :n], block[:n, n:] = a, b
    exact = np.asarray(expm(block * dt), float)
    return exact[:n, :n], exact[:n, n:]


def state_matrices(model: Model, x: ArrayLike | None = None, u: ArrayLike | None = None):
    """A (n, n) and B (n, nu) of the model linearised at state x and input u (default: straight course)."""
    point = initial_state(model) if x is None else _array(x, 1)
    given = inputs_of(model, np.zeros(1)) if u is None else _array(u, 1)[None]
    _, by_state, by_input, _ = slopes_at(model, point[None], given)
    return by_state[0], by_input[0]


def slopes_at(model: Model, states: ArrayLike, inputs: ArrayLike) -> tuple[NDArray[np.float64], ...]:
    """State derivatives (N, n) at states (N, n) and inputs (N, nu), and their slopes by the states (N, n, n), by the
    inputs (N, n, nu) and by the coefficients (N, n, p)."""
    x, u = _array(states, 2), _array(inputs, 2)
    kernels, (count, n), nu = model.kernels, x.shape, u.shape[1]
    rates, by_state, by_input = np.empty((count, n)), np.empty((count, n * n)), np.zeros((count, n * nu))
    sparse, unit, theta = np.zeros((count, kernels.JT_COLUMN.size)), np.eye(n).ravel(), model.theta
    for row in range(count):
        kernels.tangent(x[row], u[row], theta, unit, n, rates[row], by_state[row], by_input[row], sparse[row])
    by_coefficient = np.zeros((count, n, len(model.coordinates)))
    by_coefficient[:, kernels.JT_ROW, kernels.JT_COLUMN] = sparse
    return rates, by_state.reshape(-1, n, n), by_input.reshape(-1, n, nu), by_coefficient


def accelerations(model: Model, states: ArrayLike, inputs: ArrayLike) -> NDArray[np.float64]:
    """State derivatives (N, n) at states (N, n) and inputs (N, nu)."""
    x, u = _array(states, 2), _array(inputs, 2)
    rates = np.empty_like(x)
    for row in range(len(x)):
        model.kernels.rhs(x[row], u[row], model.theta, rates[row])
    return rates


def stable_step_s(model: Model, x: ArrayLike, u: ArrayLike) -> float:
    """Largest step, s, whose product with the largest eigenvalue of the model about state x and input u is STABLE;
    infinite where the model does not change there."""
    state, given = _array(x, 1), _array(u, 1)
    moves = np.vstack([np.zeros(state.size), np.diag(DIFFERENCE * (1.0 + np.abs(state)))])
    rates = accelerations(model, state + moves, np.tile(given, (len(moves), 1)))
    slopes = (rates[1:] - rates[0]) / np.diag(moves[1:])[:, None]
    fastest = float(np.max(np.abs(np.linalg.eigvals(slopes)))) if np.isfinite(slopes).all() else 0.0
    return STABLE / fastest if fastest > 0.0 else np.inf


def closed_loop(
    model: Model,
    dt: float,
    control: ClosedLoop,
    environment: ArrayLike | None = None,
    x0: ArrayLike | None = None,
    integrator: str = "rk4",
) -> SimulatedRun:
    """Hull, steering gear and helmsman together, N+1 samples long as `control.reference` is.

    Commands change at samples and the rudder is linear between them, so that `simulate` repeats the run exactly
    from its rudder column; where the model's instruments hold a linkage, from the angle that it makes of that column.

    Parameters
    ----------
    environment : (N+1, 7): current north, east [m/s, towards], wind north, east [m/s, towards], body-fixed forces
        X [N], Y [N], N [N m]; 3-DOF models only.

    Raises
    ------
    BadInput : if the model has no environment variant, or no windage data while there is wind.
    """
    from . import drivers

    count = len(control.reference)
    inputs = inputs_of(model, np.zeros(count))
    kernels, theta = model.kernels, model.theta
    if environment is not None and np.any(environment):
        surroundings = _array(environment, 2)
        kernels, theta = model.environment(wind=bool(np.any(surroundings[:, 2:4])))
        inputs = np.ascontiguousarray(np.hstack([inputs, surroundings]))
    start = initial_state(model) if x0 is None else _array(x0, 1)
    states, order, rudder = np.empty((count, start.size)), np.empty(count), np.empty(count)
    heading, yaw_rate = model.states.index("psi"), model.states.index("r")
    drivers.closed_loop(
        kernels.rhs, start, inputs, theta, dt, substeps(model, dt), integrator == "euler",
        KINDS.index(control.kind), _array(control.reference, 1), setting_of(control), heading, yaw_rate,
        linkage(model.instruments), states, order, rudder,
    )  # fmt: skip
    return SimulatedRun(dt * np.arange(count, dtype=float), states, order, rudder)


def setting_of(control: ClosedLoop) -> NDArray[np.float64]:
    """The numbers (10,) of a closed loop as the drivers take them; the rudder starts midships."""
    gear, order = control.gear, (control.execute_s, control.rudder_rad, control.heading_rad, control.first)
    return np.array([*order, gear.lag_s, gear.rate_rad_s, gear.max_rad, control.kp, control.kd, 0.0])


def _array(values: ArrayLike, dimensions: int) -> NDArray[np.float64]:
    if isinstance(values, np.ndarray) and values.flags.carray and values.dtype == np.float64:
        array = values
    else:
        array = np.require(values, dtype=float, requirements=["C", "W"])  # read-only arrays would need other kernels
    if array.ndim != dimensions:
        raise BadInput(f"an array of {dimensions} dimensions is needed, not {array.ndim}")
    return array


def gates_of(regimes: Sequence[Regime]) -> NDArray[np.float64]:
    """Regimes (W, 4) as the drivers take them: place of the variable in `VARIABLES`, sign, threshold, width."""
    return np.array([[[*VARIABLES].index(w.variable), w.sign, w.threshold, w.width] for w in regimes], float)


def places_of(states: Sequence[str]) -> NDArray[np.int64]:
    """Places of u, v, r among the states, -1 for one that the model has not."""
    return np.array([states.index(name) if name in states else -1 for name in ("u", "v", "r")], np.int64)
