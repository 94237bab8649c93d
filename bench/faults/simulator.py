"""One run of the truth: ship, manoeuvre, injected effects, gusts -> dense states and rudder."""

from __future__ import annotations

import warnings
from collections.abc import Callable, Generator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field
from functools import cache, lru_cache
from types import FunctionType
from typing import TYPE_CHECKING, Any

import numpy as np
from numba import NumbaExperimentalFeatureWarning, types

from ...datasets.manoeuvres import Manoeuvre, parse_manoeuvre
from ...models.compilation import callback
from ...models.errors import BadInput
from . import equations, integrate
from .ships import FIRST, TrueShip

if TYPE_CHECKING:
    from .effects.base import EffectKind

REFERENCE_RUDDER = np.deg2rad(10.0)
CONSTANTS = 6
"""Length of the vector that a force function gets: the size, then the constants of the effect."""
_VECTOR = types.Array(types.float64, 1, "C")
FORCE = types.void(_VECTOR, types.float64, _VECTOR, types.float64, types.float64, types.float64, _VECTOR)
"""Numba type of a force function (`effects.forces.force_kind`)."""


@dataclass(frozen=True, eq=False)
class Gusts:
    """Zero-mean forces with one correlation time (Ornstein-Uhlenbeck), fixed to the earth or to the hull.

    level: sd of the yaw moment as a rudder angle, rad; the sway force is 1.5 times, surge .75 times what the rudder
    gives in sway at that angle.
    """

    level: float
    correlation_s: float
    earth_fixed: bool


@dataclass(frozen=True, eq=False)
class RunPlan:
    """What is injected in one record, sorted by where it acts.

    extra: force functions with their vectors (`effects.forces`); wave: (rms rad, peak rad/s, damping) or None; sensors:
    kinds with parameters.
    """

    ship: TrueShip
    terms: equations.Terms = equations.NO_TERMS
    chain: integrate.Chain = field(default_factory=integrate.Chain)
    extra: tuple[tuple[Callable[..., None], np.ndarray], ...] = ()
    wave: tuple[float, float, float] | None = None
    sensors: tuple[tuple[EffectKind, Mapping[str, Any]], ...] = ()


@dataclass(frozen=True, eq=False)
class DenseRun:
    """A dense run: step s, states (n + 1, 8), recorded rudder on half steps (2n + 1,), wave motion (n + 1, 2)."""

    step_s: float
    states: np.ndarray
    rudder: np.ndarray
    hull: np.ndarray
    wave: np.ndarray

    @property
    def time_s(self) -> np.ndarray:
        """Times (n + 1,)."""
        return self.step_s * np.arange(len(self.states))


@lru_cache(maxsize=64)
def rudder_force(ship: TrueShip) -> tuple[float, float]:
    """Sway force and yaw moment (response ships: yaw acceleration) of 10 deg of rudder on a straight course."""
    if not ship.is_3dof:
        per = "T" if ship.kind == FIRST else "h"
        return 1.0, abs(ship.coefficient("K") / ship.coefficient(per)) * REFERENCE_RUDDER
    out = np.zeros((2, 8))
    x = straight(ship)
    for row, angle in zip(out, (0.0, REFERENCE_RUDDER), strict=True):
        args = (equations.ship_numbers(ship, 1.0, 1.0), equations.NO_TERMS, *further_forces(()), 0.0, x)
        with first_class_functions():
            equations.derivative(ship.kind, ship.coefficients, *args, angle, 0.0, 0.0, 0.0, np.zeros(5), row)
    force = ship.mass @ (out[1, :3] - out[0, :3])
    return abs(float(force[1])), abs(float(force[2]))


def straight(ship: TrueShip, heading_rad: float = 0.0) -> np.ndarray:
    """State (8,) of a straight course through still water at the ship's speed."""
    return np.array([ship.speed_m_s, 0.0, 0.0, 0.0, 0.0, heading_rad, 0.0, 0.0])


def start(plan: RunPlan, heading_rad: float) -> np.ndarray:
    """State (8,) at rest in the moving water, over ground."""
    x = straight(plan.ship, heading_rad)
    north, east = plan.terms.current_north, plan.terms.current_east
    x[0] += north * np.cos(heading_rad) + east * np.sin(heading_rad)
    x[1] += -north * np.sin(heading_rad) + east * np.cos(heading_rad)
    return x


def simulate(
    plan: RunPlan,
    manoeuvre: str,
    duration_s: float,
    rng: np.random.Generator,
    heading_rad: float = 0.0,
    gusts: Gusts | None = None,
    helmsman_sd: float = 0.0,
    prescribed: np.ndarray | None = None,
    step_s: float | None = None,
    planted: np.ndarray | None = None,
) -> DenseRun:
    """Run one manoeuvre.

    helmsman_sd: error of the heading by which a zigzag is steered, rad, renewed twice a second (of a full-scale
    ship).  prescribed (2n + 1,): rudder angle on half steps, instead of the manoeuvre's.  planted (n + 1, 3): further
    forces X, Y, N in the axes of the gusts.
    """
    ship = plan.ship
    h = step_s or ship.step_s
    n = round(duration_s / h)
    orders, loop = steering(ship, parse_manoeuvre(manoeuvre), h, n, rng)
    forces = gust_forces(ship, gusts, h, n, rng) + (0.0 if planted is None else planted)
    wave = narrow_band(plan.wave, h, n, rng)
    hold = max(round(0.5 * ship.clock / h), 1)
    seen = np.repeat(rng.normal(0.0, 1.0, n // hold + 1) * helmsman_sd, hold)[:n] + wave[:n, 0]
    states, rudder, hull = np.empty((n + 1, integrate.STATES)), np.empty(2 * n + 1), np.empty(2 * n + 1)
    limits = np.array([ship.lag_s, ship.rate_rad_s, ship.max_rad])
    with first_class_functions():
        integrate.run(
            ship.kind, ship.coefficients, equations.ship_numbers(ship, *rudder_force(ship)), plan.terms,
            *further_forces(plan.extra), plan.chain, start(plan, heading_rad), h, orders, loop, seen, limits,
            np.zeros(0) if prescribed is None else np.ascontiguousarray(prescribed, float),
            forces, bool(gusts and gusts.earth_fixed), states, rudder, hull,
        )  # fmt: skip
    return DenseRun(h, states, rudder, hull, wave)


@contextmanager
def first_class_functions() -> Generator[None]:
    """Without numba's warning that functions as arguments are experimental."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", NumbaExperimentalFeatureWarning)
        yield


def no_force(a, t, x, d, length, speed, out):
    """The force function of a record without further forces."""


def further_forces(extra: Sequence[tuple[Callable[..., None], np.ndarray]]) -> tuple[np.ndarray, tuple]:
    """Vectors (m, 6) and compiled functions (m) for the equations; one that does nothing where there is none."""
    extra = extra or ((no_force, np.zeros(CONSTANTS)),)
    return np.vstack([a for _, a in extra]), tuple(compiled(function) for function, _ in extra)


@cache
def compiled(function: FunctionType) -> Any:
    """A force function as a numba C function, cached on disk."""
    return callback(FORCE, function)


def steering(ship: TrueShip, m: Manoeuvre, h: float, n: int, rng: np.random.Generator):
    """Rudder orders (n,) in the ship's sign, and the zigzag's loop (5,); BadInput for a manoeuvre without either."""
    t = h * np.arange(n)
    execute = 10.0 * ship.clock
    loop = np.zeros(5)
    size = m.values[0] if m.values else 0.0
    if m.kind == "zigzag":
        loop[:] = 1.0, ship.starboard * size, m.values[1], execute, m.side
        return np.zeros(n), loop
    if m.kind == "turn":
        order = np.where(t >= execute, m.side * size, 0.0)
    elif m.kind == "pullout":
        order = np.where((t >= execute) & (t < 0.5 * (execute + n * h)), m.side * size, 0.0)
    elif m.kind == "sine":
        order = m.side * sum(a * np.sin(w * t) for a, w in zip(m.values[0::2], m.values[1::2], strict=True))
    elif m.kind in ("prbs", "steps"):
        ticks = np.floor(t / m.values[1]).astype(int)
        draws = rng.choice([-1.0, 1.0], ticks[-1] + 1) if m.kind == "prbs" else rng.uniform(-1, 1, ticks[-1] + 1)
        order = size * draws[ticks]
    elif m.kind == "straight":
        order = np.zeros(n)
    else:
        raise BadInput(f"the truth simulator does not steer {m.text!r}", hint="zigzag, turn, sine, prbs, steps, ...")
    return ship.starboard * order, loop


def gust_forces(ship: TrueShip, gusts: Gusts | None, h: float, n: int, rng: np.random.Generator) -> np.ndarray:
    """Forces X, Y, N (n + 1, 3) of a gust, sampled exactly at the steps (linear between them)."""
    if gusts is None:
        return np.zeros((n + 1, 3))
    return np.column_stack([sd * walk(gusts.correlation_s, h, n, rng) for sd in gust_sd(ship, gusts)])


def gust_sd(ship: TrueShip, gusts: Gusts) -> Sequence[float]:
    """Standard deviations of a gust's X, Y, N."""
    side, yaw = rudder_force(ship)
    part = gusts.level / REFERENCE_RUDDER
    return (0.75 * part * side, 1.5 * part * side, part * yaw) if ship.is_3dof else (0.0, 0.0, part * yaw)


def walk(correlation_s: float, h: float, n: int, rng: np.random.Generator) -> np.ndarray:
    """A stationary Ornstein-Uhlenbeck series (n + 1,) of unit variance."""
    from scipy.signal import lfilter

    decay = np.exp(-h / correlation_s)
    shocks = rng.standard_normal(n + 1)
    shocks[1:] *= np.sqrt(1.0 - decay**2)
    return np.asarray(lfilter([1.0], [1.0, -decay], shocks))


def narrow_band(wave: tuple[float, float, float] | None, h: float, n: int, rng: np.random.Generator) -> np.ndarray:
    """Motion and its rate (n + 1, 2) of w'' + 2 zeta omega w' + omega^2 w = white noise, rms of w as given."""
    if wave is None:
        return np.zeros((n + 1, 2))
    from scipy.linalg import expm

    rms, omega, zeta = wave
    step = expm(h * np.array([[0.0, 1.0], [-(omega**2), -2.0 * zeta * omega]]))
    steady = np.diag([rms**2, (rms * omega) ** 2])
    root = np.linalg.cholesky(steady - step @ steady @ step.T + 1e-18 * steady)
    x = np.sqrt(np.diag(steady)) * rng.standard_normal(2)
    kicks = rng.standard_normal((n, 2)) @ root.T
    out = np.empty((n + 1, 2))
    out[0] = x
    for k in range(n):
        x = step @ x + kicks[k]
        out[k + 1] = x
    return out
