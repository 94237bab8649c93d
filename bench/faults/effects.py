"""The catalogue of what can be planted: every cause of the taxonomy, the ships that can carry it, its sizes.

`CAUSES[cause].draw` gives a shape of about faint size; `scaled` multiplies what is its size, and `strength` finds the
factor.  Lists of values are per record (training records first, then the held-out ones).
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from . import anticipated, unforeseen
from .ships import DEGREE, FIRST, SECOND, Ship
from .simulator import NO_EXTRA, Plan

HULL = {
    "mariner": ("Yv", "Yr", "Nv", "Nr", "Nvvr", "Yvvr", "Xvv"),
    "s175": ("Yuv", "Yur", "Nuv", "Nur", "Nvvr", "Yvvv", "Xvr"),
    "kvlcc2-l7": ("Y_v", "Y_r", "N_v", "N_r", "N_vvr", "Y_vvv", "R_0"),
    "response-1": ("T", "alpha"),
    "response-2": ("g", "h", "alpha"),
    "cargo": ("T1", "T2", "T3"),
}
SHALLOW = {"mariner": ("Yv", "Nv", "Nr"), "s175": ("Yuv", "Nuv", "Nur"), "kvlcc2-l7": ("Y_v", "N_v", "N_r")}


@dataclass(frozen=True)
class Setting:
    """What a draw may look at."""

    ship: Ship
    duration_s: float
    train: int
    held_out: int
    places: Callable[[], tuple[float, float]]
    """A place (north, east) in ship lengths that a training record passes without effects."""

    @property
    def records(self) -> int:
        """Number of records."""
        return self.train + self.held_out


@dataclass(frozen=True)
class Cause:
    """One kind of effect.

    units: parameter -> unit; sized: the parameters that grow with strength, up to `cap` in absolute value;
    inverse: the size is a limit, which falls with strength down to `cap`; random: it only adds variance.
    """

    units: dict[str, str]
    sized: tuple[str, ...]
    draw: Callable[[Setting, np.random.Generator], dict[str, Any]]
    cap: float = np.inf
    inverse: bool = False
    random: bool = False
    response: bool = False
    three_dof: bool = True
    command: bool = False


@dataclass(frozen=True)
class Effect:
    """A cause with its parameters; tuples hold one value per record."""

    cause: str
    parameters: Mapping[str, Any]

    def scaled(self, factor: float) -> Effect:
        """The effect with its size multiplied (a limit: divided), within its cap."""
        facts = CATALOGUE[self.cause]

        def grown(value):
            if isinstance(value, tuple):
                return tuple(grown(one) for one in value)
            if facts.inverse:
                return max(value / factor, facts.cap)
            return float(np.clip(value * factor, -facts.cap, facts.cap))

        return Effect(self.cause, {k: grown(v) if k in facts.sized else v for k, v in self.parameters.items()})

    def at(self, record: int) -> dict[str, Any]:
        """The parameters in one record."""
        whole = ("channels", "row")
        return {k: v[record] if isinstance(v, tuple) and k not in whole else v for k, v in self.parameters.items()}


def sign(rng: np.random.Generator, negative: float = 0.5) -> float:
    """-1 or 1."""
    return -1.0 if rng.random() < negative else 1.0


def scalar(name: str, unit: str, size: Callable[[Ship], float], negative: float = 0.5, **facts) -> Cause:
    """A cause with one number of random sign (negative with that probability; 0: positive)."""

    def draw(s: Setting, rng: np.random.Generator) -> dict[str, float]:
        return {name: sign(rng, negative) * size(s.ship) * float(np.exp(rng.uniform(-0.5, 0.5)))}

    return Cause({name: unit}, (name,), draw, **facts)


def fixed(value: float) -> Callable[[Ship], float]:
    """The same for every ship."""
    return lambda ship: value


def per_record(size: str, direction: str, unit: str, value: Callable[[Ship], float], **facts) -> Cause:
    """A speed (or height) and a direction, drawn anew for each record."""

    def draw(s: Setting, rng: np.random.Generator) -> dict[str, tuple]:
        sizes = value(s.ship) * rng.uniform(0.7, 1.3, s.records)
        return {size: tuple(map(float, sizes)), direction: tuple(map(float, rng.uniform(-np.pi, np.pi, s.records)))}

    return Cause({size: unit, direction: "rad"}, (size,), draw, **facts)


def _fault(s: Setting, rng):
    return {"e": -0.03 * float(rng.uniform(0.6, 1.4)), "t0": float(rng.uniform(0.25, 0.65) * s.duration_s)}


def _delay_velocity(s: Setting, rng):
    return {"tau": 0.2 * s.ship.clock * rng.uniform(0.7, 1.4), "attitude": float(rng.random() < 0.5)}


def _swap(s: Setting, rng):
    pairs = [("surge_m_s", "sway_m_s"), ("north_m", "east_m")]
    return {"channels": pairs[rng.integers(2)]}


def _waves(s: Setting, rng):
    def around(value, spread):
        return tuple(float(value * x) for x in rng.uniform(1 - spread, 1 + spread, s.records))

    omega = rng.uniform(0.5, 0.9) / s.ship.clock
    return {
        "rms": around(0.1 * DEGREE, 0.2),
        "omega": around(omega, 0.05),
        "damping": around(rng.uniform(0.05, 0.15), 0.1),
    }


def _force(s: Setting, rng):
    from .simulator import rudder_force

    side, yaw = rudder_force(s.ship)
    direction = rng.standard_normal(3)
    direction /= np.linalg.norm(direction)
    return dict(zip("XYN", map(float, 0.005 * direction * np.array([side, side, yaw])), strict=True))


def _crossflow(s: Setting, rng) -> dict[str, Any]:
    size = _prime(s.ship)
    draws = -size * rng.uniform(0.3, 1.5, 4) * np.array([4.0, 4.0, 1.0, 1.0])
    return dict(zip(("Yrv", "Yvr", "Nvr", "Nrv"), map(float, draws), strict=True))


def _prime(ship: Ship) -> float:
    """Size of a damping term in the ship's own prime system (0.5 rho L d is some 20 times smaller than 0.5 rho L^2)."""
    return {"mariner": 3e-5, "s175": 3e-5, "kvlcc2-l7": 5e-4, "cargo": 1.0}.get(ship.id, 0.1)


def _coefficient(s: Setting, rng):
    return {"name": str(rng.choice(HULL[s.ship.id])), "fraction": 0.02 * sign(rng) * rng.uniform(0.7, 1.4)}


def _loss(s: Setting, rng):
    time = s.ship.coefficient("T") if s.ship.kind == FIRST else s.ship.coefficient("g")
    return {"drop": 0.03, "recovery": float(time * rng.uniform(1.0, 3.0))}


def _lead(s: Setting, rng):
    t2 = 0.02 * s.ship.coefficient("T") * rng.uniform(0.7, 1.4)
    return {"T2": float(t2), "T3": float(t2 * rng.uniform(0.1, 0.6))}


BOTH = {"response": True}
CAUSES: dict[str, Cause] = {
    "rudder_offset": scalar("delta0", "rad", fixed(0.1 * DEGREE), **BOTH),
    "rudder_effectiveness": scalar("e", "1", fixed(0.01), 0.8, cap=0.8, **BOTH),
    "rudder_delay": scalar("tau", "s", lambda s: 0.2 * s.clock, 0.0, **BOTH),
    "rudder_fault": Cause({"e": "1", "t0": "s"}, ("e",), _fault, cap=0.95, **BOTH),
    "rudder_backlash": scalar("b", "rad", fixed(0.3 * DEGREE), 0.0, cap=10 * DEGREE, **BOTH),
    "rudder_rate_limit": scalar(
        "rate",
        "rad/s",
        lambda s: min(s.rate_rad_s, 20 * DEGREE / s.lag_s),
        0.0,
        cap=1e-4,
        inverse=True,
        command=True,
        **BOTH,
    ),
    "rudder_saturation": scalar("limit", "rad", fixed(24 * DEGREE), 0.0, cap=0.02, inverse=True, command=True, **BOTH),
    "rudder_sign": Cause({}, (), lambda s, rng: {}, **BOTH),
    "yaw_rate_bias": scalar("b", "rad/s", lambda s: 0.003 * DEGREE / s.clock, **BOTH),
    "yaw_rate_scale": scalar("s", "1", fixed(0.01), cap=0.6, **BOTH),
    "heading_offset": scalar("b", "rad", fixed(0.1 * DEGREE)),
    "speed_scale": scalar("s", "1", fixed(0.002), cap=0.6),
    "sway_offset": scalar("b", "m/s", lambda s: 0.005 * s.clock),
    "heading_delay": scalar("tau", "s", lambda s: 0.2 * s.clock, 0.0, **BOTH),
    "velocity_delay": Cause({"tau": "s", "attitude": "0 or 1"}, ("tau",), _delay_velocity),
    "earth_frame_velocity": Cause({}, (), lambda s, rng: {}),
    "channel_swap": Cause({"channels": "pair"}, (), _swap),
    "axis_misalignment": scalar("angle", "rad", fixed(0.1 * DEGREE), cap=0.6),
    "outliers": scalar("share", "1", fixed(0.005), 0.0, cap=0.1, random=True, **BOTH),
    "clock_jitter": scalar("sd", "s", lambda s: 0.05 * s.clock, 0.0, random=True, **BOTH),
    "current": per_record("speed", "towards", "m/s", lambda s: 0.03 * s.clock),
    "wind": per_record("speed", "from", "m/s", lambda s: 0.7 * s.clock),
    "wave_motion": Cause({"rms": "rad", "omega": "rad/s", "damping": "1"}, ("rms",), _waves, random=True, **BOTH),
    "wave_drift": per_record("Hs", "from", "m", lambda s: 0.3 * s.clock**2),
    "constant_force": Cause({"X": "N", "Y": "N", "N": "N m"}, ("X", "Y", "N"), _force),
    "yaw_damping_quadratic": scalar("Nrr", "1", _prime, 0.75),
    "yaw_damping_cubic": scalar("Nrrr", "1", _prime, 0.75),
    "sway_damping_quadratic": scalar("Yvv", "1", lambda s: 10 * _prime(s), 0.75),
    "crossflow_coupling": Cause(
        dict.fromkeys(("Yrv", "Yvr", "Nvr", "Nrv"), "1"), ("Yrv", "Yvr", "Nvr", "Nrv"), _crossflow
    ),
    "speed_loss": Cause({"drop": "1", "recovery": "s"}, ("drop",), _loss, response=True, three_dof=False),
    "second_order_lead": Cause({"T2": "s", "T3": "s"}, ("T2", "T3"), _lead, response=True, three_dof=False),
    "loading_change": scalar("fraction", "1", fixed(0.01), cap=0.6),
    "shallow_water": scalar("depth_ratio", "1", fixed(12.0), 0.0, cap=1.15, inverse=True),
    "coefficient_shift": Cause({"name": "", "fraction": "1"}, ("fraction",), _coefficient, cap=0.9, **BOTH),
}
#: Further terms of a response ship: alpha r|r| (s/rad) and alpha r^3 (s2/rad2) beside what it has
RESPONSE_DAMPING = {
    "yaw_damping_quadratic": ("response-1", "response-2", "cargo"),
    "yaw_damping_cubic": ("cargo",),
}


def _unknown(kind: str) -> Cause:
    def draw(s: Setting, rng: np.random.Generator) -> dict[str, Any]:
        ship = s.ship
        if kind == "sensor_ramp":
            channel = str(rng.choice(anticipated.RAMPED))
            return {"channel": channel, "size": sign(rng) * 0.05 * DEGREE}
        if kind in unforeseen.IDS:
            row = unforeseen.draw(kind, ship.starboard, ship.clock, s.duration_s, s.places(), rng)
        else:
            row = anticipated.draw(kind, ship.is_3dof, ship.clock, s.duration_s, rng)
        return {"row": tuple(map(float, row)), "size": 0.005}

    response = kind in anticipated.KINDS or kind in unforeseen.RESPONSE
    return Cause({"size": "rudder force at 10 deg"}, ("size",), draw, response=response)


ANTICIPATED: dict[str, Cause] = {kind: _unknown(kind) for kind in anticipated.KINDS}
UNFORESEEN: dict[str, Cause] = {kind: _unknown(kind) for kind in unforeseen.IDS}
CATALOGUE: dict[str, Cause] = {**CAUSES, **ANTICIPATED, **UNFORESEEN}


def carries(ship: Ship, cause: str) -> bool:
    """Whether a ship can carry a cause."""
    facts = CATALOGUE[cause]
    if ship.is_3dof:
        return facts.three_dof
    if cause in RESPONSE_DAMPING:
        return ship.id in RESPONSE_DAMPING[cause]
    if cause == "second_order_lead":
        return ship.kind == FIRST
    return facts.response


def plan_of(ship: Ship, effects: tuple[Effect, ...], record: int) -> Plan:
    """What the effects do in one record."""
    dynamic: dict[str, float] = {}
    chain: dict[str, float] = {}
    sensors: dict[str, dict] = {}
    extra, wave = [NO_EXTRA], None
    for effect in effects:
        p = effect.at(record)
        if effect.cause in CHAINED:
            chain |= {CHAINED[effect.cause][k]: v for k, v in p.items()}
        elif effect.cause in FORCES:
            dynamic |= FORCES[effect.cause](p)
        elif effect.cause in CHANGED:
            ship = CHANGED[effect.cause](ship, p)
        elif "row" in p:
            row = np.array(p["row"])
            row[1] *= p["size"]
            extra.append(np.concatenate([[1.0 if effect.cause in ANTICIPATED else 2.0], row])[None, :])
        elif effect.cause == "wave_motion":
            wave = (p["rms"], p["omega"], p["damping"])
        else:
            sensors[effect.cause] = p
    return Plan(ship, dynamic, chain, np.vstack(extra), wave, sensors)


CHAINED = {
    "rudder_offset": {"delta0": "offset"},
    "rudder_effectiveness": {"e": "effectiveness"},
    "rudder_delay": {"tau": "delay"},
    "rudder_fault": {"e": "fault", "t0": "fault_time"},
    "rudder_backlash": {"b": "play"},
    "rudder_rate_limit": {"rate": "rate_limit"},
    "rudder_saturation": {"limit": "saturation"},
}


def _damping(name: str, response: str) -> Callable[[dict], dict[str, float]]:
    return lambda p: {name: p[name], response: p[name]}


FORCES: dict[str, Callable[[dict], dict[str, float]]] = {
    "current": lambda p: {
        "current_north": p["speed"] * np.cos(p["towards"]), "current_east": p["speed"] * np.sin(p["towards"])
    },
    "wind": lambda p: {
        "wind_north": -p["speed"] * np.cos(p["from"]), "wind_east": -p["speed"] * np.sin(p["from"])
    },
    "wave_drift": lambda p: {"Hs": p["Hs"], "wave_from": p["from"]},
    "constant_force": dict,
    "yaw_damping_quadratic": _damping("Nrr", "r_quadratic"),
    "yaw_damping_cubic": _damping("Nrrr", "r_cubic"),
    "sway_damping_quadratic": dict,
    "crossflow_coupling": dict,
    "speed_loss": dict,
    "loading_change": lambda p: {"mass_fraction": p["fraction"]},
}  # fmt: skip


def _shifted(ship: Ship, p: dict) -> Ship:
    name, grow = p["name"], 1.0 + p["fraction"]
    if ship.id == "cargo" and name in ("T1", "T2"):
        times = {k: ship.facts["parameters"][k]["value"] * (grow if k == name else 1.0) for k in ("T1", "T2")}
        return ship.with_coefficients(h=times["T1"] * times["T2"], g=times["T1"] + times["T2"])
    return ship.with_coefficients(**{name: ship.coefficient(name) * grow})


def _led(ship: Ship, p: dict) -> Ship:
    """(1 + T s)(1 + T2 s) r + alpha r^3 = K (1 + T3 s) delta for the first-order ship's own T.

    Both times are moved up where T2 is too short to be integrated, which leaves their effect as it is.
    """
    from dataclasses import replace

    from .ships import SECOND_NAMES

    t, short = ship.coefficient("T"), max(0.02 - p["T2"], 0.0)
    t2, t3 = p["T2"] + short, p["T3"] + short
    values = {"h": t * t2, "g": t + t2, "K": ship.coefficient("K"), "T3": t3, "alpha": ship.coefficient("alpha")}
    numbers = np.array([values[name] for name in SECOND_NAMES])
    return replace(ship, kind=SECOND, names=tuple(SECOND_NAMES), coefficients=numbers)


def shallow_factors(ship: Ship, depth_ratio: float) -> tuple[float, float, float]:
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


def _shallow(ship: Ship, p: dict) -> Ship:
    factors = zip(SHALLOW[ship.id], shallow_factors(ship, p["depth_ratio"]), strict=True)
    return ship.with_coefficients(**{name: ship.coefficient(name) * factor for name, factor in factors})


CHANGED: dict[str, Callable[[Ship, dict], Ship]] = {
    "coefficient_shift": _shifted,
    "second_order_lead": _led,
    "shallow_water": _shallow,
}
