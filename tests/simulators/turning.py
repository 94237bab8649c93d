"""Ships that respond in yaw, drift and lose speed, sailed and measured by equations of their own: nothing of
helmbench.models, helmbench.datasets or helmbench.estimation takes part.

With sigma the time in L/U0, w = U/U0, rho = r L/U0 and positions in lengths,

    d rho / d sigma = -damping w rho - cubic rho^3 / w + gain (w^2 (1 - race) + race) delta
    d u / d sigma = surge (1 - u |u| - speed_loss rho^2 u / w),  v = -pivot rho

and the rudder goes at a constant rate.  Orders are given, and indices read, where the heading crosses exactly.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from scipy.integrate import solve_ivp

NAMES = ("damping", "gain", "race", "cubic", "pivot", "surge", "speed_loss")


@dataclass(frozen=True)
class TurningShip:
    """A ship: the numbers of the module's equations, length m, speed m/s, rate of the rudder rad/s."""

    numbers: dict[str, float]
    length: float
    speed: float
    rate: float

    @property
    def clock(self) -> float:
        """L/U0, s."""
        return self.length / self.speed


def draw(rng: np.random.Generator) -> TurningShip:
    """A ship from a dinghy's size to a tanker's, with numbers about those of published ships."""
    numbers = {
        "damping": rng.uniform(0.0, 1.2),
        "gain": math.exp(rng.uniform(math.log(0.5), math.log(1.4))),
        "race": rng.uniform(0.15, 0.5),
        "cubic": math.exp(rng.uniform(math.log(0.7), math.log(12.0))),
        "pivot": rng.uniform(0.3, 0.5),
        "surge": rng.uniform(0.035, 0.08),
        "speed_loss": rng.uniform(6.0, 11.0),
    }
    length = math.exp(rng.uniform(math.log(3.0), math.log(350.0)))
    speed = rng.uniform(0.12, 0.25) * math.sqrt(9.81 * length)
    return TurningShip(numbers, length, speed, math.radians(2.5) * math.sqrt(300.0 / length))


def indices_of(ship: TurningShip, rudder_deg: float, heading_deg: float | None = None) -> dict[str, float]:
    """Indices as a file has them, of a turn, or of a zigzag where a heading is given; nan where not reached."""
    order = math.radians(rudder_deg)
    if heading_deg is None:
        return turn(ship, order)
    found = zigzag(ship, order, math.radians(heading_deg))
    return dict(zip(("first_overshoot_deg", "second_overshoot_deg"), found, strict=True))


def rates(ship: TurningShip, t, x, angle):
    """d/d sigma of (u, rho, psi, north, east, distance) at the rudder angle angle(t)."""
    n = ship.numbers
    u, rho, psi = x[:3]
    v = -n["pivot"] * rho
    w = math.hypot(u, v)
    force = n["gain"] * (w * w * (1.0 - n["race"]) + n["race"]) * angle(t)
    yaw = force - n["damping"] * w * rho - n["cubic"] * rho**3 / w
    surge = n["surge"] * (1.0 - u * abs(u) - n["speed_loss"] * rho * rho * u / w)
    return [surge, yaw, rho, u * math.cos(psi) - v * math.sin(psi), u * math.sin(psi) + v * math.cos(psi), w]


def leg(ship: TurningShip, x, start_angle: float, order: float, events, until: float):
    """Sail from x with the rudder going from start_angle to order; the solution, and the angle over time."""
    rate = ship.rate * ship.clock

    def angle(t):
        return start_angle + math.copysign(min(rate * t, abs(order - start_angle)), order - start_angle)

    arrived = abs(order - start_angle) / rate
    options = {"rtol": 1e-8, "atol": 1e-10, "max_step": max(0.02, arrived / 8.0), "events": events}
    return solve_ivp(lambda t, y: rates(ship, t, y, angle), (0.0, until), x, **options), angle


def crossing(level: float, terminal: bool, of: int = 2):
    """The event that state number `of` reaches a level."""

    def event(t, x):
        return x[of] - level

    event.terminal = terminal
    return event


def turn(ship: TurningShip, order: float) -> dict[str, float]:
    """Distances in lengths, speed over approach speed, yaw rate in deg/s."""
    start = [1.0, 0.0, 0.0, 0.0, 0.0, 0.0]
    events = [crossing(0.5 * math.pi, False), crossing(math.pi, False), crossing(math.radians(10.0), False)]
    found, _ = leg(ship, start, 0.0, order, events, 49.0)
    at90, at180, at10 = (y[0] if len(y) else np.full(6, math.nan) for y in found.y_events)
    u, rho = found.y[:2, -1]
    speed = math.hypot(u, ship.numbers["pivot"] * rho)
    return {
        "advance_lengths": at90[3],
        "transfer_lengths": at90[4],
        "tactical_diameter_lengths": at180[4],
        "final_diameter_lengths": 2.0 * speed / rho,
        "initial_turning_lengths": at10[5],
        "speed_ratio": speed,
        "yaw_rate_deg_s": math.degrees(rho / ship.clock),
    }


def zigzag(ship: TurningShip, order: float, heading: float) -> list[float]:
    """The first two overshoots, deg."""
    x, angle, side, found = np.array([1.0, 0.0, 0.0, 0.0, 0.0, 0.0]), 0.0, 1.0, []
    for number in range(3):
        reach = crossing(side * heading, True)
        reach.direction = side
        run, rudder = leg(ship, x, angle, side * order, [reach, crossing(0.0, False, 1)], 30.0)
        if number:
            turned = [y[2] for y in run.y_events[1]]
            found.append(abs(math.degrees(turned[0] - x[2])) if turned else math.nan)
        if not len(run.y_events[0]):
            return [*found, math.nan, math.nan][:2]
        x, angle, side = run.y_events[0][0], rudder(run.t[-1]), -side
    return found
