"""Craft whose steering law is known, sailed by equations of their own: nothing of helmbench.models takes part.

A craft of length L sails at U, which follows the revolutions n with a lag.  Laws of the yaw rate r under the command d:

    flow      r' = -(a0 + |U|/(T' L)) r + U |U| K'/(T' L^2) d
    race      r' = -U/(T' L) r + (k U^2 + (1 - k) (U0 n)^2) K'/(T' L^2) d
    thruster  r' = -(a0 + U/(T' L)) r + (U0/L)^2 K'/T' d
    twin      as thruster, by two propellers whose thrusts are recorded, port 1.25 times as strong as starboard
    azimuth   as thruster, d = n^2 sin of the recorded angle, which is turned up to 70 degrees

A craft of the law flow may go ahead and astern (U < 0).  Every record has a neutral angle and a current of its own,
and slow gusts act on the yaw moment.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import pandas as pd

from helmbench.datasets.record import Record

LAWS = ("flow", "race", "thruster")
ALLOCATED = ("twin", "azimuth")
STRONGER, FULL = 1.25, 400.0
"""Effect of the port propeller over that of starboard, and thrust, N, of a command of one."""
SUBSTEPS = 16


@dataclass(frozen=True)
class SimulatedCraft:
    """A craft: law, extras and the numbers of the module's equations, SI."""

    law: str
    length: float
    speed: float
    time: float
    gain: float
    share: float = 0.4
    still: float = 0.0
    offset: float = 0.0
    delay: float = 0.0
    quadratic: float = 0.0

    @property
    def clock(self) -> float:
        """L/U0, s."""
        return self.length / self.speed


def draw(rng: np.random.Generator, law: str, *extras: str) -> SimulatedCraft:
    """A craft of a law, with some of offset, delay, quadratic."""
    length = float(np.exp(rng.uniform(np.log(1.0), np.log(10.0))))
    speed = float(rng.uniform(0.18, 0.3) * np.sqrt(9.81 * length))
    clock = length / speed
    return SimulatedCraft(
        law, length, speed, float(rng.uniform(0.6, 1.6)), float(rng.uniform(0.9, 1.8)),
        still=0.0 if law in ("flow", "race") else 0.3 / clock,
        offset=float(rng.choice([-1.0, 1.0]) * rng.uniform(0.05, 0.09)) if "offset" in extras else 0.0,
        delay=float(rng.uniform(0.35, 0.6) * clock) if "delay" in extras else 0.0,
        quadratic=float(rng.uniform(1.5, 2.5)) if "quadratic" in extras else 0.0,
    )  # fmt: skip


def sailed(
    rng: np.random.Generator,
    craft: SimulatedCraft,
    name: str,
    noise: float = 1.0,
    length: float = 65.0,
    weather: float = 1.0,
    astern: bool = False,
) -> Record:
    """A record of about `length` L/U0 with steps of the command and of the revolutions, from rest.

    noise : multiple of the usual sensor noise;  weather : of the usual gusts, currents and neutral angles;
    astern : the revolutions turn in one sense and the other.
    """
    dt = craft.clock / 15.0
    count = int(length * rng.uniform(0.85, 1.15) * 15)
    command = _steps(rng, count, int(15 * rng.uniform(2.0, 4.0)), 1.2 if craft.law == "azimuth" else 0.35)
    turns = (0.0 if astern else 0.95) + _steps(rng, count, int(15 * rng.uniform(9.0, 14.0)), 1.0 if astern else 0.5)
    own = craft.offset + weather * rng.normal(0.0, 0.006)
    late = round(craft.delay / dt * SUBSTEPS)
    acting, recorded = _acting(craft, command, turns)
    fine = np.interp(np.arange(count * SUBSTEPS) / SUBSTEPS, np.arange(count), acting)
    felt = np.concatenate([np.full(late, fine[0]), fine[: fine.size - late]]) + own
    gust, h = 0.0, dt / SUBSTEPS
    moment = craft.gain / craft.time / craft.clock**2
    shaken = weather * 0.012 * moment * np.sqrt(h / craft.clock)
    r, psi, u, x, y = 0.0, rng.uniform(-3.0, 3.0), 0.0, 0.0, 0.0
    drift = weather * rng.normal(0.0, 0.02, 2) * craft.speed
    rows = np.empty((count, 5))
    for k in range(fine.size):
        if k % SUBSTEPS == 0:
            rows[k // SUBSTEPS] = r, psi, u, x, y
        n = turns[k // SUBSTEPS]
        gust += h / (2.0 * craft.clock) * -gust + shaken * rng.standard_normal()
        r += h * (_acceleration(craft, r, u, n, felt[k], moment) + gust)
        u += h / (3.0 * craft.clock) * (craft.speed * n - u * (1.0 + 0.5 * (r * craft.clock) ** 2))
        psi += h * r
        x += h * (u * np.cos(psi) + drift[0])
        y += h * (u * np.sin(psi) + drift[1])
    size = noise * np.array([0.01 / craft.clock, 0.004, 0.01 * craft.speed, 0.01 * craft.length, 0.01 * craft.length])
    seen = rows + size * rng.standard_normal(rows.shape)
    channels = {
        **recorded,
        "heading_rad": np.mod(seen[:, 1] + np.pi, 2.0 * np.pi) - np.pi,
        "yaw_rate_rad_s": seen[:, 0],
        "surge_m_s": seen[:, 2],
        "north_m": seen[:, 3],
        "east_m": seen[:, 4],
    }
    channels |= {"propeller_rps": 10.0 * turns} if craft.law in ("race", "azimuth") else {}
    return Record.from_dataframe(pd.DataFrame({"time_s": dt * np.arange(count), **channels}), name)


def _acceleration(craft: SimulatedCraft, r: float, u: float, n: float, d: float, moment: float) -> float:
    flow = u * abs(u) / craft.speed**2
    damping = -(craft.still + abs(u) / (craft.time * craft.length)) * r - craft.quadratic * abs(r) * r
    force = {"flow": flow, "race": craft.share * flow + (1.0 - craft.share) * n**2}.get(craft.law, 1.0)
    return damping + force * moment * d


def _acting(craft: SimulatedCraft, command: np.ndarray, turns: np.ndarray) -> tuple[np.ndarray, dict[str, np.ndarray]]:
    """What turns the hull (count,), in commands of one, and the columns that a record shows of it."""
    if craft.law == "azimuth":
        return 0.35 * turns**2 * np.sin(command), {"rudder_rad": command}
    if craft.law == "twin":
        port, starboard = (FULL * (0.5 * turns + side * 0.5 * command) for side in (1.0, -1.0))
        weak = 2.0 / (1.0 + STRONGER)
        acting = weak * (STRONGER * port - starboard) / FULL
        return acting, {"thrust_port_N": port, "thrust_starboard_N": starboard}
    return command, {"rudder_command_rad": command}


def _steps(rng: np.random.Generator, count: int, hold: int, size: float) -> np.ndarray:
    """A series (count,) of steps of either sign, each held for about `hold` samples; zero at first."""
    values, done = np.zeros(count), hold // 2
    sign = 1.0
    while done < count:
        n = int(hold * rng.uniform(0.6, 1.4)) + 1
        values[done : done + n] = sign * size * rng.uniform(0.5, 1.0)
        done, sign = done + n, -sign
    return values
