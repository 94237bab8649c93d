"""A 3-DOF model from a ship's particulars alone, by published regressions; `calibrate` corrects it with records.

Hull forces are those of the MMG standard method (family `mmg`), in primes of 0.5 rho L d U^2.  With k = 2 d/L, the
block coefficient C_b and s = C_b B/L, linear derivatives are the means of three regressions,

    Clarke, Gedling & Hine 1983 (times L/d, for the reference area L d instead of L^2)
        Y_v = -pi d/L (1 + .40 C_b B/d)              Y_r = -pi d/L (-.5 + 2.2 B/L - .080 B/d)
        N_v = -pi d/L (.5 + 2.4 d/L)                 N_r = -pi d/L (.25 + .039 B/d - .56 B/L)
    Kijima, Katsuno, Nakiri & Furukawa 1990
        Y_v = -(pi k/2 + 1.4 s)   Y_r = m + m_x - 1.5 s   N_v = -k   N_r = -.54 k + k^2
    Yoshimura & Masumoto 2012
        Y_v = -(pi k/2 + 1.4 s)   Y_r = m_x + .5 s        N_v = -k   N_r = -.54 k + k^2

and the others are of Yoshimura & Masumoto 2012.  They come from models of merchant and fishing ships, C_b .5 to .85 and
L/B 2.6 to 7.2: a derivative is known within about 20 %, a rudder's inflow less well.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, fields
from pathlib import Path
from typing import TYPE_CHECKING, Any

from .errors import BadInput

if TYPE_CHECKING:
    from .model import Model

SLENDERNESS, FULLNESS = (1.5, 15.0), (0.2, 1.0)
"""L/B and C_b that a ship can have."""
CURVE = (0.363, -0.275, -0.112)
"""K_T/(P/D) over J/(P/D): the propeller of KVLCC2 (Yasukawa & Yoshimura 2015), thrust going with pitch less advance."""
WAKE_IN_TURNS = (2.0, 1.35)
"""C_1 and C_2: KVLCC2, mean of both sides (Yasukawa & Yoshimura 2015)."""
STEPS = 200
"""Integration steps in the time L/U."""


@dataclass(frozen=True)
class Particulars:
    """A ship, SI units: length, breadth, draught, displaced volume; speed and revolutions of a straight course; area
    and span of the rudder; diameter and pitch ratio of the propeller; place of the centre of gravity, + forward of
    midship; density of the water.

    Raises
    ------
    BadInput : numbers that no ship has.
    """

    L: float
    B: float
    d: float
    nabla: float
    speed_m_s: float
    n0_rps: float
    A_R: float
    H_R: float
    D_P: float
    pitch_ratio: float = 0.8
    x_G: float = 0.0
    rho: float = 1025.0
    title: str = "ship from its particulars"

    def __post_init__(self) -> None:
        for entry in fields(self):
            value = getattr(self, entry.name)
            if entry.name not in ("title", "x_G") and not (math.isfinite(value) and value > 0.0):
                raise BadInput(f"particulars {entry.name}: {value!r} is no number above 0")
        for name, value, (low, high) in (("L/B", self.L / self.B, SLENDERNESS), ("C_b", self.block, FULLNESS)):
            if not low <= value <= high:
                hint = "lengths in m, the displaced volume nabla in m3"
                raise BadInput(f"particulars: {name} is {value:.3g}, outside {low:g} to {high:g}", hint=hint)
        if thrust(self, propeller(self)) <= 0.0:
            said = f"particulars: no thrust at {self.n0_rps:g} 1/s and {self.speed_m_s:g} m/s"
            raise BadInput(said, hint="check speed_m_s, n0_rps, D_P and pitch_ratio")

    @property
    def block(self) -> float:
        """Block coefficient."""
        return self.nabla / (self.L * self.B * self.d)

    @property
    def mass(self) -> float:
        """Mass in primes of 0.5 rho L^2 d."""
        return 2.0 * self.nabla / (self.L**2 * self.d)


NAMES = tuple(entry.name for entry in fields(Particulars))
NEEDED = tuple(name for name in NAMES if name not in ("pitch_ratio", "x_G", "rho", "title"))


def added_masses(p: Particulars) -> dict[str, float]:
    """m_x, m_y (primes of 0.5 rho L^2 d) and J_z (of 0.5 rho L^4 d): m_x = .05 m, the others as Zhou, Sheng & Feng 1983
    fitted Motora's charts."""
    c, slender, flat = p.block, p.L / p.B, p.d / p.B
    long = slender * flat
    sway = 0.882 - 0.54 * c * (1.0 - 1.6 * flat) - 0.156 * (1.0 - 0.673 * c) * slender
    sway += 0.826 * long * (1.0 - 0.678 * flat) - 0.638 * c * long * (1.0 - 0.669 * flat)
    gyration = 0.01 * (33.0 - 76.85 * c * (1.0 - 0.784 * c) + 3.43 * slender * (1.0 - 0.63 * c))
    return {"m_x": 0.05 * p.mass, "m_y": max(sway, 0.2) * p.mass, "J_z": gyration**2 * p.mass}


def linear_derivatives(p: Particulars) -> dict[str, dict[str, float]]:
    """Source -> Y_v, Y_r, N_v, N_r; see the module."""
    k, s, area = 2.0 * p.d / p.L, p.block * p.B / p.L, math.pi * p.d / p.L
    along = added_masses(p)["m_x"]
    common = {"Y_v": -(0.5 * math.pi * k + 1.4 * s), "N_v": -k, "N_r": -0.54 * k + k**2}
    clarke = {
        "Y_v": -area * (1.0 + 0.40 * p.block * p.B / p.d),
        "Y_r": -area * (-0.5 + 2.2 * p.B / p.L - 0.080 * p.B / p.d),
        "N_v": -area * (0.5 + 2.4 * p.d / p.L),
        "N_r": -area * (0.25 + 0.039 * p.B / p.d - 0.56 * p.B / p.L),
    }
    return {
        "Clarke 1983": clarke,
        "Kijima 1990": {**common, "Y_r": p.mass + along - 1.5 * s},
        "Yoshimura & Masumoto 2012": {**common, "Y_r": along + 0.5 * s},
    }


def hull(p: Particulars) -> dict[str, float]:
    """Coefficients of the hull without its resistance: linear ones as in the module, the others of Yoshimura & Masumoto
    2012."""
    s, slender, blunt = p.block * p.B / p.L, p.L / p.B, 1.0 - p.block
    sources = linear_derivatives(p).values()
    linear = {name: sum(source[name] for source in sources) / 3.0 for name in ("Y_v", "Y_r", "N_v", "N_r")}
    m_y = added_masses(p)["m_y"]
    return linear | {
        "X_vv": 1.15 * s - 0.18, "X_vr": m_y - 1.91 * s + 0.08, "X_rr": -0.085 * s + 0.008 - p.x_G / p.L * m_y,
        "X_vvvv": -6.68 * s + 1.1,
        "Y_vvv": -0.185 * slender + 0.48, "Y_vvr": -0.75, "Y_vrr": -(0.26 * blunt * slender + 0.11), "Y_rrr": -0.051,
        "N_vvv": 0.69 * p.block - 0.66, "N_vvr": 1.55 * s - 0.76, "N_vrr": -0.075 * blunt * slender - 0.098,
        "N_rrr": 0.25 * s - 0.056,
    }  # fmt: skip


def rudder(p: Particulars) -> dict[str, float]:
    """Rudder and its interaction with hull and propeller.

    Slope 6.13 a / (2.25 + a) of the aspect ratio a (Fujii & Tsuda 1961); 1 - t_R = .61 and l_R = -.9 (Yoshimura &
    Masumoto 2012); a_H = .627 C_b - .153 (Quadvlieg 2013) at x_H = -.45 L (Aoki et al. 2006); epsilon = -156.5 s^2 +
    41.6 s - 1.76, kappa = .55 - .8 s (Kijima et al. 1990), gamma_R = 2.06 s + .14 (Yoshimura & Masumoto 2012).
    """
    s, aspect = p.block * p.B / p.L, p.H_R**2 / p.A_R
    hull_share = max(0.627 * p.block - 0.153, 0.0)
    gamma = 2.06 * s + 0.14
    return {
        "CRu": 0.61, "CRv": 1.0 + hull_share, "CRr": -0.5 - 0.45 * hull_share,
        "f_alpha": 6.13 * aspect / (2.25 + aspect), "H_R": p.H_R, "A_R": p.A_R,
        "epsilon": min(max(-156.5 * s**2 + 41.6 * s - 1.76, 0.8), 1.3), "kappa": max(0.55 - 0.8 * s, 0.2),
        "l_R": -0.9, "gamma_R_plus": gamma, "gamma_R_minus": gamma,
    }  # fmt: skip


def propeller(p: Particulars) -> dict[str, float]:
    """Propeller in the wake: w = .5 C_b - .05 (Taylor 1933), t = .6 w (Schoenherr 1934), thrust as `CURVE`."""
    wake, pitch = min(max(0.5 * p.block - 0.05, 0.05), 0.6), p.pitch_ratio
    return {
        "D_P": p.D_P, "w_P0": wake, "t_P": 0.6 * wake, "x_P": -0.48,
        "C_1": WAKE_IN_TURNS[0], "C_2_plus": WAKE_IN_TURNS[1], "C_2_minus": WAKE_IN_TURNS[1],
        "k_0": CURVE[0] * pitch, "k_1": CURVE[1], "k_2": CURVE[2] / pitch,
    }  # fmt: skip


def thrust(p: Particulars, own: Mapping[str, float]) -> float:
    """Thrust over the water's density, m4/s2, at speed and revolutions of the straight course.

    own : as `propeller` gives it.
    """
    inflow, tip = p.speed_m_s * (1.0 - own["w_P0"]), p.n0_rps * p.D_P
    return p.D_P**2 * (own["k_0"] * tip**2 + own["k_1"] * tip * inflow + own["k_2"] * inflow**2)


def resistance(p: Particulars, own: Mapping[str, float]) -> float:
    """R_0, prime of 0.5 rho L d U^2, that balances the thrust of the straight course; own : as `propeller` gives it."""
    return (1.0 - own["t_P"]) * thrust(p, own) / (0.5 * p.L * p.d * p.speed_m_s**2)


def numbers_of(p: Particulars) -> dict[str, float]:
    """Coefficients and constants of the ship as a model of the family mmg, by name."""
    screw = propeller(p)
    values = hull(p) | rudder(p) | screw | added_masses(p) | {"R_0": resistance(p, screw)}
    turning = p.rho * p.nabla * ((0.25 * p.L) ** 2 + p.x_G**2)
    return values | {"L": p.L, "d": p.d, "nabla": p.nabla, "x_G": p.x_G, "I_zz": turning, "rho": p.rho}


def particulars_of(model: Model) -> Particulars | None:
    """What the file of a vessel states among its particulars, constants and settings; None where something lacks."""
    known: dict[str, Any] = dict(zip(model.constant_names, model.constants.tolist(), strict=True))
    known |= {**model.particulars, "speed_m_s": model.speed_m_s, "n0_rps": model.n0_rps, "title": model.title}
    stated = {name: known[name] for name in NAMES if known.get(name) is not None}
    return Particulars(**stated) if all(name in stated for name in NEEDED) else None


def read_particulars(path: Path) -> Particulars:
    """The ship of a YAML file of particulars: the names of `Particulars`, SI units.

    Raises
    ------
    BadInput : the file cannot be read, or says what no ship has.
    """
    from .data_file import load

    content = load(path)
    if not isinstance(content, dict):
        raise BadInput("no particulars", file=path, hint=f"give {', '.join(NEEDED)}")
    unknown, missing = [n for n in content if n not in NAMES], [n for n in NEEDED if n not in content]
    wrong = [n for n, v in content.items() if n != "title" and (isinstance(v, bool) or not isinstance(v, int | float))]
    for said, which in (("unknown", unknown), ("missing", missing), ("not numbers:", wrong)):
        if which:
            raise BadInput(
                f"particulars {said} {', '.join(map(str, which))}", file=path, hint=f"give {', '.join(NAMES)}"
            )
    try:
        return Particulars(**content)
    except BadInput as error:
        raise BadInput(error.message, file=path, hint=error.hint) from None
