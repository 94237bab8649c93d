"""Zigzags of the K-T vehicle of paper 000 with a rudder held between samples, by its difference equation or exactly."""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from ....datasets.record import Record
from ....models.model import Model, resolve
from ....models.simulate import state_matrices, zoh_matrices

STEP_S, DURATION_S = 0.1, 20.0
ORDER = ("T2", "T1", "K", "T3")
"""Parameters as the paper's eq 10 orders them."""


class SampleStep(NamedTuple):
    """One sample: x(k) = state (n, n) x(k-1) + rudder (n,) delta(k)."""

    state: np.ndarray
    rudder: np.ndarray


def vehicle() -> Model:
    """The K-T equation with the coefficients of eq 23."""
    return resolve("remus-kt")


def difference_step(model: Model, dt: float = STEP_S) -> SampleStep:
    """Eq 8: every derivative of eq 5 replaced by a backward difference, which is implicit Euler."""
    a, b = state_matrices(model)
    implicit = np.linalg.inv(np.eye(len(a)) - dt * a)
    return SampleStep(implicit, implicit @ (dt * b[:, 0]))


def continuous_step(model: Model, dt: float = STEP_S) -> SampleStep:
    """Eq 5 itself, solved exactly over a sample."""
    state, rudder = zoh_matrices(model, dt)
    return SampleStep(state, rudder[:, 0])


class Gear(NamedTuple):
    """Steering of a zigzag: rudder rate rad/s, lag s, time of the first order s, yaw rate at the start rad/s."""

    rate: float = np.inf
    lag: float = 0.0
    execute_s: float = 0.0
    yaw_rate: float = 0.0


AT_ONCE = Gear()


def zigzag(step: SampleStep, angle_deg: float = 20.0, gear: Gear = AT_ONCE, dt: float = STEP_S) -> Record:
    """Rudder and heading (N+1,) of an angle/angle zigzag: midships at first, over at k = 1, reversed on psi(k - 1).

    The rudder in row k acts from sample k - 1 to k, as in eq 8.  It follows its order at once, or as the gear has it.
    """
    n, angle = round(DURATION_S / dt), np.deg2rad(angle_deg)
    first = max(1, round(gear.execute_s / dt))
    follow = 1.0 if gear.lag <= 0.0 else 1.0 - np.exp(-dt / gear.lag)
    x, side = np.zeros(len(step.rudder)), 1.0
    x[1] = gear.yaw_rate
    heading, rudder = np.zeros(n + 1), np.zeros(n + 1)
    for k in range(1, n + 1):
        if side * heading[k - 1] >= angle:
            side = -side
        wanted = side * angle if k >= first else 0.0
        move = (wanted - rudder[k - 1]) * follow
        rudder[k] = rudder[k - 1] + np.clip(move, -gear.rate * dt, gear.rate * dt)
        x = step.state @ x + step.rudder * rudder[k]
        heading[k] = x[2]
    return Record(dt * np.arange(n + 1), {"heading_rad": heading, "rudder_rad": rudder}, f"zigzag {angle_deg:g}")


def driven(step: SampleStep, rudder_rad: np.ndarray) -> np.ndarray:
    """Heading (N+1,) under a given rudder (N+1,), from rest."""
    x, heading = np.zeros(len(step.rudder)), np.zeros(len(rudder_rad))
    for k in range(1, len(rudder_rad)):
        x = step.state @ x + step.rudder * rudder_rad[k]
        heading[k] = x[2]
    return heading


def held_ahead(record: Record) -> Record:
    """The same run with row k holding the rudder from k on, as the integral schemes read a record."""
    rudder = record.rudder()
    return record.with_channels(rudder_rad=np.append(rudder[1:], rudder[-1]))


def noisy(record: Record, sd_rad: float, rng: np.random.Generator) -> Record:
    """White noise on the heading."""
    return record.with_channels(heading_rad=record.column("heading_rad") + rng.normal(0.0, sd_rad, record.n))


def bound_at_rest(
    model: Model, record: Record, sd_rad: float, step_of: Callable[[Model], SampleStep] = difference_step
) -> dict[str, float]:
    """Cramer-Rao bound of the parameters under white heading noise, the rudder and the start at rest being known."""
    slopes = []
    for i, value in enumerate(model.coefficients):
        nudge = 1e-6 * value * np.eye(len(model.coefficients))[i]
        up, down = (
            driven(step_of(model.with_coefficients(model.coefficients + sign * nudge)), record.rudder())
            for sign in (1.0, -1.0)
        )
        slopes.append((up - down) / (2e-6 * value))
    information = np.array(slopes) @ np.array(slopes).T
    return dict(zip(model.coordinates, sd_rad * np.sqrt(np.diag(np.linalg.inv(information))), strict=True))
