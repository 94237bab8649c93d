"""The ships of the truth simulator: numbers from the vessel files, packed for the hand-written equations.

Only data are shared with the rest of the suite.  Forces of a 3-DOF ship are in N and N m; a response ship has one
"force", its yaw acceleration (rad/s^2 of r_dot for a first-order ship, of r_ddot times 1 s for a second-order one).
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field, replace
from functools import lru_cache
from typing import Any

import numpy as np

from ...models.vessel import read_vessel, vessel_files

MARINER, S175, KVLCC2, FIRST, SECOND = range(5)
KINDS = {
    "abkowitz": MARINER,
    "mmg-son-nomoto": S175,
    "mmg": KVLCC2,
    "nomoto-1": FIRST,
    "nomoto-1-cubic": FIRST,
    "nomoto-2": SECOND,
    "nomoto-2-cubic": SECOND,
}
VESSELS = ("mariner", "s175", "kvlcc2-l7", "response-1", "response-2", "cargo")
DEGREE = math.pi / 180.0
MARINER_LENGTH = 160.93


def _names(text: str) -> tuple[str, ...]:
    return tuple(text.split())


ABKOWITZ_T = _names("u uu v r d vvv ddd vvr vvd vdd du vu ru duu rrr vrr vuu ruu rdd rrd rvd 0")
SECOND_NAMES = ("h", "g", "K", "T3", "alpha")
NAMES = {
    MARINER: (
        *_names("Xu Xuu Xuuu Xvv Xrr Xdd Xddu Xvr Xvd Xvdu Xuvv Xurr Xuvr Xrd Xurd X0"),
        *(letter + term for letter in "YN" for term in ABKOWITZ_T),
    ),
    S175: _names(
        "Xuu Xvv Xrr Xvr CP CRu Yuv Yur Yvvv Yrrr Yvrr Yvvr CRv Nuv Nur Nvvv Nrrr Nvrr Nvvr CRr m_x m_y D_P w_P "
        "tau x_P a_0 a_1 A_R f_alpha epsilon k_x gamma_R c_Rr c_Rrrr c_Rrrv"
    ),
    KVLCC2: _names(
        "R_0 X_vv X_vr X_rr X_vvvv Y_v Y_r Y_vvv Y_vvr Y_vrr Y_rrr N_v N_r N_vvv N_vvr N_vrr N_rrr CRu CRv CRr m_x "
        "m_y D_P t_P w_P0 x_P C_1 C_2_plus C_2_minus k_0 k_1 k_2 H_R A_R f_alpha epsilon kappa l_R gamma_R_plus "
        "gamma_R_minus d"
    ),
    FIRST: ("T", "K", "alpha"),
    SECOND: SECOND_NAMES,
}
"""Coefficients of each kind of ship in the order in which the equations take them."""
#: Steering gears of ships whose file has none that a sampled record can show: lag s, rate rad/s
GEARS = {"response-1": (0.3, 10 * DEGREE), "response-2": (0.3, 10 * DEGREE), "kvlcc2-l7": (0.1, 15.8 * DEGREE)}
BLOCKS = ("parameters", "constants")
"""Blocks of a vessel file that hold the numbers of the equations."""
DIMENSIONS = ("L", "d", "nabla", "x_G", "rho", "U0", "x_P", "m")
"""Numbers that set scales and places: the same for all sister ships."""
#: Speed (m/s) and length (m) of response ships, which their papers do not give: they set the scales only
SIZES = {"response-1": (1.2, 7.0), "response-2": (1.2, 7.0), "cargo": (7.7, 160.0)}
#: Rigid-body mass, x_G and I_z in primes of 0.5 rho L^3, L, 0.5 rho L^5 (Chislett & Stroem-Tejsen 1965, MSS mariner.m)
MARINER_RIGID = (0.00798, -0.023, 0.000392)


@dataclass(frozen=True, eq=False)
class TrueShip:
    """One ship of the truth.

    Parameters
    ----------
    kind : which equations. coefficients : (p,) in the order of `names`.
    mass : (3, 3) of the whole mass matrix (rigid and added), N s^2/m and so on; identity for a response ship.
    rigid : rigid-body mass kg, m x_G kg m, I_z kg m^2.
    propeller_rps : revolutions (0 where there are none).
    primes : 0.5 rho S and the length that make a prime force q S U^2 and a moment q S L U^2.
    windage : A_F, A_L (m2), cx, cy, cn, kn, delta, rho_air (`equations.wind_force`).
    lag_s, rate_rad_s, max_rad : steering gear.
    """

    id: str
    kind: int
    names: tuple[str, ...]
    coefficients: np.ndarray
    mass: np.ndarray
    rigid: np.ndarray
    propeller_rps: float
    primes: tuple[float, float]
    windage: np.ndarray
    lag_s: float
    rate_rad_s: float
    max_rad: float
    speed_m_s: float
    length_m: float
    rho: float
    starboard: int
    facts: dict[str, Any] = field(repr=False, default_factory=dict)

    @property
    def is_3dof(self) -> bool:
        """Whether surge, sway and yaw move (else yaw only)."""
        return self.kind <= KVLCC2

    @property
    def clock(self) -> float:
        """Time scale against a full-scale ship: 1 for Mariner, about .2 for a 7 m model."""
        return math.sqrt(self.length_m / MARINER_LENGTH)

    @property
    def step_s(self) -> float:
        """Integration step, s."""
        return 0.05 if self.clock > 0.5 else 0.02

    def coefficient(self, name: str) -> float:
        """The coefficient of that name."""
        return float(self.coefficients[self.names.index(name)])

    def with_coefficients(self, **changes: float) -> TrueShip:
        """The ship with some coefficients replaced."""
        values = self.coefficients.copy()
        for name, value in changes.items():
            values[self.names.index(name)] = value
        return replace(self, coefficients=values)


@lru_cache
def ship(vessel: str, factors: tuple[tuple[str, float], ...] = ()) -> TrueShip:
    """The ship of a vessel file; KeyError for a family without hand-written equations.

    factors : (name, factor) of numbers in which a sister ship differs from the published one, of `sister_numbers`.
    """
    facts: dict[str, Any] = read_vessel(vessel_files()[vessel])
    kind = KINDS[facts["family"]]
    numbers = {k: v["value"] for block in BLOCKS for k, v in (facts.get(block) or {}).items()}
    numbers |= {name: numbers[name] * factor for name, factor in factors}
    own = {name: one | {"value": numbers[name]} for name, one in (facts.get("parameters") or {}).items()}
    facts = {**facts, "parameters": own}
    gear = facts["rudder"]
    lag, rate = GEARS.get(vessel, (gear["lag_s"], (gear["rate_deg_s"] or 1e6) * DEGREE))
    common = {
        "id": vessel,
        "kind": kind,
        "names": NAMES[kind],
        "propeller_rps": float(facts.get("n0_rps") or 0.0),
        "lag_s": lag,
        "rate_rad_s": rate,
        "max_rad": gear["max_deg"] * DEGREE,
        "starboard": -1 if facts["positive_rudder"] == "port" else 1,
        "facts": facts,
    }
    return _response(vessel, kind, numbers, common) if kind in (FIRST, SECOND) else _three(kind, numbers, facts, common)


def sister_numbers(vessel: str) -> tuple[str, ...]:
    """Numbers of a vessel file in which a sister ship may differ: those of the motion, not of the main dimensions."""
    facts = read_vessel(vessel_files()[vessel])
    names = (name for block in BLOCKS for name, one in (facts.get(block) or {}).items() if one["value"])
    return tuple(name for name in names if name not in DIMENSIONS)


def _response(vessel: str, kind: int, numbers: dict, common: dict) -> TrueShip:
    if "T1" in numbers:
        numbers = numbers | {"h": numbers["T1"] * numbers["T2"], "g": numbers["T1"] + numbers["T2"]}
    speed, length = SIZES[vessel]
    return TrueShip(
        **common,
        coefficients=np.array([float(numbers.get(name, 0.0)) for name in NAMES[kind]]),
        mass=np.eye(3),
        rigid=np.zeros(3),
        primes=(1.0, 1.0),
        windage=np.zeros(8),
        speed_m_s=speed,
        length_m=length,
        rho=1000.0,
    )


def _three(kind: int, numbers: dict, facts: dict, common: dict) -> TrueShip:
    length, rho = float(numbers["L"]), float(facts["particulars"]["rho"]["value"])
    area = length * (numbers["d"] if kind == KVLCC2 else length)
    force = 0.5 * rho * area
    rigid, mass = MASSES[kind](numbers, rho, length, force)
    return TrueShip(
        **common,
        coefficients=np.array([float(numbers[name]) for name in NAMES[kind]]),
        mass=mass,
        rigid=np.array(rigid, float),
        primes=(force, length),
        windage=_windage(facts["windage"], length),
        speed_m_s=float(facts["speed_m_s"]),
        length_m=length,
        rho=rho,
    )


def _mariner_mass(k: dict, rho: float, length: float, force: float):
    unit = force * length
    m, x_g, inertia = MARINER_RIGID
    rows = [[k["m11"], 0, 0], [0, k["m22"], k["m23"] * length], [0, k["m32"] * length, k["m33"] * length**2]]
    return (m * unit, m * x_g * unit * length, inertia * unit * length**2), np.array(rows) * unit


def _s175_mass(k: dict, rho: float, length: float, force: float):
    unit = force * length
    cross = k["m_y"] * k["alpha_y"] * length
    rows = [[k["m"] + k["m_x"], 0, 0], [0, k["m"] + k["m_y"], cross], [0, cross, (k["I_z"] + k["J_z"]) * length**2]]
    return (k["m"] * unit, 0.0, k["I_z"] * unit * length**2), np.array(rows) * unit


def _kvlcc2_mass(k: dict, rho: float, length: float, force: float):
    """Added masses in primes of 0.5 rho L^2 d and 0.5 rho L^4 d; moments about midship."""
    unit = force * length
    m = rho * k["nabla"]
    gyration, inertia = m * k["x_G"], k["I_zz"]
    rows = [
        [m + k["m_x"] * unit, 0, 0],
        [0, m + k["m_y"] * unit, gyration],
        [0, gyration, inertia + k["J_z"] * unit * length**2],
    ]
    return (m, gyration, inertia), np.array(rows)


MASSES = {MARINER: _mariner_mass, S175: _s175_mass, KVLCC2: _kvlcc2_mass}


def _windage(block: dict | None, length: float) -> np.ndarray:
    """Windage constants; a ship without any gets Mariner's areas in proportion to the square of its length."""
    if block is None:
        scale = (length / MARINER_LENGTH) ** 2
        return np.array([450.0 * scale, 1800.0 * scale, 0.7, 0.8, 0.1, 0.0, 0.0, 1.225])
    areas = [block["A_F_m2"], block["A_L_m2"]]
    if block["form"] == "sinusoidal":
        return np.array([*areas, block["cx"], block["cy"], block["cn"], 0.0, 0.0, block["rho_air"]])
    return np.array([*areas, block["CDl_AF"], block["CDt"], 0.0, 0.18, block["delta"], block["rho_air"]])
