"""Effects of weather: wind, current and waves, different in each record."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from ..ships import DEGREE, TrueShip
from .base import EffectKind, Setting, any_ship


def weather(units: dict[str, str], size: Callable[[TrueShip], float], **row: Any) -> EffectKind:
    """A speed or height, about `size` for a ship, and a direction, the two names of `units`: drawn for each record."""
    name, direction = units

    def draw(s: Setting, rng: np.random.Generator) -> dict[str, Any]:
        sizes = size(s.ship) * rng.uniform(0.7, 1.3, s.records)
        angles = rng.uniform(-np.pi, np.pi, s.records)
        return {name: tuple(map(float, sizes)), direction: tuple(map(float, angles))}

    return EffectKind(units=units, sized=(name,), directions=(direction,), draw=draw, **row)


def draw_motion(s: Setting, rng: np.random.Generator) -> dict[str, tuple[float, ...]]:
    def around(value: float, spread: float) -> tuple[float, ...]:
        return tuple(float(value * x) for x in rng.uniform(1 - spread, 1 + spread, s.records))

    omega = rng.uniform(0.5, 0.9) / s.ship.clock
    rms, peak = around(0.1 * DEGREE, 0.2), around(omega, 0.05)
    return {"rms": rms, "omega": peak, "damping": around(rng.uniform(0.05, 0.15), 0.1)}


ROWS = (
    weather(  # a uniform current towards a direction
        id="current", rank=20, units={"speed": "m/s", "towards": "rad"}, size=lambda ship: 0.03 * ship.clock,
        forces=lambda p: {
            "current_north": p["speed"] * np.cos(p["towards"]), "current_east": p["speed"] * np.sin(p["towards"]),
        },
    ),
    weather(  # a steady wind from a direction
        id="wind", rank=21, units={"speed": "m/s", "from": "rad"}, size=lambda ship: 0.7 * ship.clock,
        forces=lambda p: {
            "wind_north": -p["speed"] * np.cos(p["from"]), "wind_east": -p["speed"] * np.sin(p["from"]),
        },
    ),
    weather(  # mean second-order wave forces of a significant wave height Hs
        id="wave_drift", rank=23, units={"Hs": "m", "from": "rad"}, size=lambda ship: 0.3 * ship.clock**2,
        forces=lambda p: {"Hs": p["Hs"], "wave_from": p["from"]},
    ),
    EffectKind(  # first-order wave motion of heading and yaw rate, narrow-band
        id="wave_motion", rank=22, units={"rms": "rad", "omega": "rad/s", "damping": "1"}, sized=("rms",),
        variance_only=True, carried_by=any_ship, draw=draw_motion, wave=lambda p: (p["rms"], p["omega"], p["damping"]),
        truths=lambda p, ship, details: {
            "period": 2.0 * np.pi / p["omega"], "damping": p["damping"], "heading_rms": p["rms"],
        },
    ),
)  # fmt: skip
