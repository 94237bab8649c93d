"""Effects of the rudder: what happens between the recorded angle and the hull."""

from __future__ import annotations

import numpy as np

from ..regimes import TrueRegime
from ..ships import DEGREE
from .base import REGIME, EffectKind, any_ship, scalar

ROWS = (
    scalar(  # the rudder at the hull is off by a constant angle
        id="rudder_offset", rank=0, parameter="delta0", unit="rad", chain=("offset",),
        size=lambda ship: 0.1 * DEGREE, carried_by=any_ship,
    ),
    scalar(  # the rudder acts 1 + e times as strongly as its recorded angle
        id="rudder_effectiveness", rank=1, parameter="e", unit="1", chain=("effectiveness",), negative=0.8, cap=0.8,
        size=lambda ship: 0.01, carried_by=any_ship,
    ),
    scalar(  # the rudder at the hull is late
        id="rudder_delay", rank=2, parameter="tau", unit="s", chain=("delay",), negative=0.0,
        size=lambda ship: 0.2 * ship.clock, carried_by=any_ship,
    ),
    scalar(  # the rudder has play: it follows only when the recorded angle has moved by b
        id="rudder_backlash", rank=4, parameter="b", unit="rad", chain=("play",), negative=0.0, cap=10 * DEGREE,
        carried_by=any_ship, size=lambda ship: 0.3 * DEGREE,
    ),
    scalar(  # the rudder moves no faster than a rate; records hold its command
        id="rudder_rate_limit", rank=5, parameter="rate", unit="rad/s", chain=("rate_limit",), negative=0.0, cap=1e-4,
        inverse=True, command=True, carried_by=any_ship,
        size=lambda ship: min(ship.rate_rad_s, 20 * DEGREE / ship.lag_s),
    ),
    scalar(  # the rudder turns no further than an angle; records hold its command
        id="rudder_saturation", rank=6, parameter="limit", unit="rad", chain=("saturation",), negative=0.0, cap=0.02,
        inverse=True, command=True, carried_by=any_ship, size=lambda ship: 24 * DEGREE,
    ),
    EffectKind(  # the rudder loses a share of its effect at a time t0
        id="rudder_fault", rank=3, units={"e": "1", "t0": "s"}, sized=("e",), cap=0.95, carried_by=any_ship,
        draw=lambda s, rng: {
            "e": -0.03 * float(rng.uniform(0.6, 1.4)), "t0": float(rng.uniform(0.25, 0.65) * s.duration_s),
        },
        rudder=lambda p: {"fault": p["e"], "fault_time": p["t0"]},
    ),
    EffectKind(  # the rudder loses a share of its force beyond an angle
        id="rudder_force_loss", group=REGIME, rank=60, units={"loss": "1", "angle": "rad"}, sized=("loss",), cap=0.8,
        carried_by=any_ship,
        right=("rudder_force", "rudder_large_angle", "rudder_effectiveness", "turning_gain"),
        draw=lambda s, rng: {
            "loss": 0.1 * float(np.exp(rng.uniform(-0.4, 0.4))), "angle": float(np.deg2rad(rng.uniform(11.0, 18.0))),
        },
        forces=lambda p: {"rudder_loss": p["loss"], "rudder_angle": p["angle"]},
        regime=lambda p, ship: TrueRegime("rudder", "above", p["angle"]),
    ),
)  # fmt: skip
