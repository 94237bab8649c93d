"""Effects of the hull and the propeller: other coefficients, further terms of the equations, other water."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from math import inf
from typing import Any

import numpy as np

from ..regimes import TrueRegime
from ..ships import FIRST, KVLCC2, S175, SECOND, SECOND_NAMES, TrueShip
from ..simulator import rudder_force
from .base import REGIME, EffectKind, Setting, any_ship, numbers, random_sign, scalar

HULL = {
    "mariner": ("Yv", "Yr", "Nv", "Nr", "Nvvr", "Yvvr", "Xvv"),
    "s175": ("Yuv", "Yur", "Nuv", "Nur", "Nvvr", "Yvvv", "Xvr"),
    "kvlcc2-l7": ("Y_v", "Y_r", "N_v", "N_r", "N_vvr", "Y_vvv", "R_0"),
    "response-1": ("T", "alpha"),
    "response-2": ("g", "h", "alpha"),
    "cargo": ("T1", "T2", "T3"),
}
SHALLOW = {"mariner": ("Yv", "Nv", "Nr"), "s175": ("Yuv", "Nuv", "Nur"), "kvlcc2-l7": ("Y_v", "N_v", "N_r")}
"""What stands for Y_v, N_v and N_r in each ship's equations."""
CROSSFLOW = ("Yrv", "Yvr", "Nvr", "Nrv")


def damping_size(ship: TrueShip) -> float:
    """Size of a damping term in the ship's own prime system (0.5 rho L d is some 20 times smaller than 0.5 rho L^2)."""
    return {"mariner": 3e-5, "s175": 3e-5, "kvlcc2-l7": 5e-4, "cargo": 1.0}.get(ship.id, 0.1)


def draw_shift(s: Setting, rng: np.random.Generator) -> dict[str, Any]:
    return {"name": str(rng.choice(HULL[s.ship.id])), "fraction": 0.02 * random_sign(rng) * rng.uniform(0.7, 1.4)}


def shifted(ship: TrueShip, p: Mapping[str, Any]) -> TrueShip:
    name, factor = p["name"], 1.0 + p["fraction"]
    if ship.id == "cargo" and name in ("T1", "T2"):
        published = ship.facts["parameters"]
        t1, t2 = (published[k]["value"] * (factor if k == name else 1.0) for k in ("T1", "T2"))
        return ship.with_coefficients(h=t1 * t2, g=t1 + t2)
    return ship.with_coefficients(**{name: ship.coefficient(name) * factor})


def true_shift(p: Mapping[str, Any], ship: TrueShip, details: Mapping[str, Any]) -> dict[str, float]:
    """A finding states the fraction of the coefficient that it names."""
    found = {f"fraction:{p['name']}": p["fraction"]}
    return found | ({"fraction": p["fraction"]} if details.get("coefficient", p["name"]) == p["name"] else {})


def draw_force(s: Setting, rng: np.random.Generator) -> dict[str, float]:
    side, yaw = rudder_force(s.ship)
    direction = rng.standard_normal(3)
    direction /= np.linalg.norm(direction)
    return dict(zip("XYN", map(float, 0.005 * direction * np.array([side, side, yaw])), strict=True))


def draw_crossflow(s: Setting, rng: np.random.Generator) -> dict[str, float]:
    draws = -damping_size(s.ship) * rng.uniform(0.3, 1.5, 4) * np.array([4.0, 4.0, 1.0, 1.0])
    return dict(zip(CROSSFLOW, map(float, draws), strict=True))


def draw_lead(s: Setting, rng: np.random.Generator) -> dict[str, float]:
    t2 = 0.02 * s.ship.coefficient("T") * rng.uniform(0.7, 1.4)
    return {"T2": float(t2), "T3": float(t2 * rng.uniform(0.1, 0.6))}


def with_lead(ship: TrueShip, p: Mapping[str, Any]) -> TrueShip:
    """(1 + T s)(1 + T2 s) r + alpha r^3 = K (1 + T3 s) delta for the first-order ship's own T.

    Both times are increased where T2 is too short to be integrated, which leaves their effect as it is.
    """
    t, short = ship.coefficient("T"), max(0.02 - p["T2"], 0.0)
    t2, t3 = p["T2"] + short, p["T3"] + short
    values = {"h": t * t2, "g": t + t2, "K": ship.coefficient("K"), "T3": t3, "alpha": ship.coefficient("alpha")}
    coefficients = np.array([values[name] for name in SECOND_NAMES])
    return replace(ship, kind=SECOND, names=SECOND_NAMES, coefficients=coefficients)


def draw_speed_loss(s: Setting, rng: np.random.Generator) -> dict[str, float]:
    time = s.ship.coefficient("T") if s.ship.kind == FIRST else s.ship.coefficient("g")
    return {"drop": 0.03, "recovery": float(time * rng.uniform(1.0, 3.0))}


def in_shallow_water(ship: TrueShip, p: Mapping[str, Any]) -> TrueShip:
    factors = zip(SHALLOW[ship.id], shallow_factors(ship, p["depth_ratio"]), strict=True)
    return ship.with_coefficients(**{name: ship.coefficient(name) * factor for name, factor in factors})


def shallow_factors(ship: TrueShip, depth_ratio: float) -> tuple[float, float, float]:
    """Y_v, N_v and N_r in water of depth h over those in deep water (Hirano et al. 1985 in Inoue's formulas).

    k_e = k/(d k/(2 h) + (x cot x)^q) with k = 2 d/L, x = pi d/(2 h) and q = 2.3, 1.7, .7 for Y_v, N_v, N_r;
    Y_v ~ pi k_e/2 + 1.4 C_b B/L, N_v ~ k_e, N_r ~ .54 k_e - k_e^2.
    """
    d = {k: ship.facts["particulars"][k]["value"] for k in ("L", "B", "d", "nabla")}
    k = 2.0 * d["d"] / d["L"]
    x = 0.5 * np.pi / depth_ratio
    ke = [k / (0.5 * k / depth_ratio + (x / np.tan(x)) ** q) for q in (2.3, 1.7, 0.7)]
    block = 1.4 * d["nabla"] / (d["L"] ** 2 * d["d"])
    sway = (0.5 * np.pi * ke[0] + block) / (0.5 * np.pi * k + block)
    return sway, ke[1] / k, (0.54 * ke[2] - ke[2] ** 2) / (0.54 * k - k**2)


ROWS = (
    scalar(  # a further yaw moment Nrr r|r|; of a response ship, alpha r|r| in s/rad
        id="yaw_damping_quadratic", rank=25, parameter="Nrr", unit="1", terms=("Nrr", "r_quadratic"), negative=0.75,
        size=damping_size, carried_by=lambda ship: ship.is_3dof or ship.id in ("response-1", "response-2", "cargo"),
    ),
    scalar(  # a further yaw moment Nrrr r^3; of a response ship without that term, alpha r^3 in s2/rad2
        id="yaw_damping_cubic", rank=26, parameter="Nrrr", unit="1", terms=("Nrrr", "r_cubic"), negative=0.75,
        size=damping_size, carried_by=lambda ship: ship.is_3dof or ship.id == "cargo",
    ),
    scalar(  # a further sway force Yvv v|v|
        id="sway_damping_quadratic", rank=27, parameter="Yvv", unit="1", terms=("Yvv",), negative=0.75,
        size=lambda ship: 10 * damping_size(ship),
    ),
    scalar(  # the ship is heavier by a fraction of her mass, with the same radius of gyration
        id="loading_change", rank=31, parameter="fraction", unit="1", terms=("mass_fraction",), cap=0.6,
        size=lambda ship: 0.01,
    ),
    EffectKind(  # one hull coefficient is larger by a fraction of itself
        id="coefficient_shift", rank=33, units={"name": "", "fraction": "1"}, sized=("fraction",), cap=0.9,
        carried_by=any_ship, draw=draw_shift, changed_ship=shifted, truths=true_shift,
    ),
    EffectKind(  # a constant force on the hull, in body axes
        id="constant_force", rank=24, units={"X": "N", "Y": "N", "N": "N m"}, sized=("X", "Y", "N"), draw=draw_force,
        forces=dict,
    ),
    EffectKind(  # further terms of sway velocity and yaw rate: r|v| and v|r| in sway force and yaw moment
        id="crossflow_coupling", rank=28, units=dict.fromkeys(CROSSFLOW, "1"), sized=CROSSFLOW, draw=draw_crossflow,
        forces=dict,
    ),
    EffectKind(  # a first-order response ship has a second time constant T2 and a lead T3
        id="second_order_lead", rank=30, units={"T2": "s", "T3": "s"}, sized=("T2", "T3"), draw=draw_lead,
        carried_by=lambda ship: ship.kind == FIRST, changed_ship=with_lead,
        truths=lambda p, ship, details: numbers(p) | {"lead": 1.0 - p["T3"] / p["T2"] if p["T2"] else inf},
    ),
    EffectKind(  # a response ship loses speed in a turn
        id="speed_loss", rank=29, units={"drop": "1", "recovery": "s"}, sized=("drop",),
        carried_by=lambda ship: not ship.is_3dof, draw=draw_speed_loss, forces=dict,
        truths=lambda p, ship, details: (
            numbers(p) | {"loss_gain": p["drop"] * (ship.length_m / ship.speed_m_s) ** 2}
        ),
    ),
    scalar(  # the water is shallow: its depth is `depth_ratio` times the draught
        id="shallow_water", rank=32, parameter="depth_ratio", unit="1", negative=0.0, cap=1.15, inverse=True,
        size=lambda ship: 12.0, changed_ship=in_shallow_water,
        truths=lambda p, ship, details: numbers(p) | {"draught_over_depth": 1.0 / p["depth_ratio"]},
    ),
    EffectKind(  # the water reaches the propeller more slowly than the wake law says beyond an angle of drift
        id="wake_loss", group=REGIME, rank=62, units={"loss": "1", "drift": "rad"}, sized=("loss",), cap=0.6,
        right=("wake_in_turns", "wake_and_thrust_deduction", "rudder_inflow"),
        carried_by=lambda ship: ship.kind in (S175, KVLCC2),  # whose equations hold a propeller
        draw=lambda s, rng: {
            "loss": 0.08 * float(np.exp(rng.uniform(-0.4, 0.4))), "drift": float(np.deg2rad(rng.uniform(3.0, 7.0))),
        },
        forces=lambda p: {"wake_loss": p["loss"], "wake_drift": p["drift"]},
        regime=lambda p, ship: TrueRegime("drift", "above", p["drift"]),
    ),
)  # fmt: skip
