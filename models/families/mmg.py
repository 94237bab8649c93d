"""3-DOF MMG models: hull, propeller and rudder as separate submodels that interact.

All definitions are written per 0.5 rho S L (forces) and 0.5 rho S L^2 (moment), S = L d or L^2 being the
reference area of the published derivatives: masses are prime values, accelerations stay in SI, and a hull force
is its prime value times q = U^2/L.  The propeller enters as K_T (n D)^2 = k0 (n D)^2 + k1 n D u_P + k2 u_P^2, which
is finite for a stopped propeller and for u = 0, where the advance ratio J is not.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import cast

import numpy as np
import sympy as sp

from ..definition import Definition, symbols
from ..primitives import absv, atan2v, step

AT_REST = sp.Float(1e-12)
"""Added to squared velocities below a root, (m/s)^2: the derivatives stay finite for a ship at rest."""
RUDDER = ["CRu", "CRv", "CRr"]

STANDARD = {
    "X": ["vv", "vr", "rr", "vvvv"],
    "Y": ["v", "r", "vvv", "vvr", "vrr", "rrr"],
    "N": ["v", "r", "vvv", "vvr", "vrr", "rrr"],
}
STANDARD_COEFFICIENTS = ["R_0", *(f"{axis}_{term}" for axis, terms in STANDARD.items() for term in terms), *RUDDER]
STANDARD_CONSTANTS = (
    "L d nabla x_G I_zz rho m_x m_y J_z D_P t_P w_P0 x_P C_1 C_2_plus C_2_minus k_0 k_1 k_2 "
    "H_R A_R f_alpha epsilon kappa l_R gamma_R_plus gamma_R_minus"
)

LOW_SPEED_COEFFICIENTS = ["R_0", "X_vv", "X_vr", "X_rr", "Y_v", "Y_r", "N_v", "N_r", "C_D", *RUDDER]
LOW_SPEED_CONSTANTS = (
    "L d nabla x_G rho m_x m_y IJ_z C_rY C_rN D_P t_P w_P0 tau C_P x_P k_0 k_1 k_2 "
    "H_R A_R f_alpha epsilon kappa l_R gamma_R_plus gamma_R_minus"
)
ROUNDED = 0.05
"""Share of the speed below which |x| is rounded in the wake and at the rudder: no kink for the integrator to cross."""
STATIONS = 8
"""Stations along the hull at which the cross flow is taken (Gauss-Legendre)."""

SURGE = ["uu", "uuu", "vv", "rr", "vr", "uvv", "uvr", "urr"]
SWAY = ["uv", "ur", "uur", "uuv", "vvv", "rrr", "vrr", "vvr", "v_absv", "v_absr", "r_absv", "r_absr"]
SON_NOMOTO_COEFFICIENTS = [
    *(f"X{term}" for term in SURGE),
    "CP",
    "CRu",
    *(f"Y{term}" for term in SWAY),
    "CRv",
    *(f"N{term}" for term in SWAY),
    "CRr",
]
SON_NOMOTO_CONSTANTS = (
    "L m m_x m_y I_z J_z D_P w_P tau x_P a_0 a_1 a_2 A_R f_alpha epsilon k_x gamma_R c_Rr c_Rrrr c_Rrrv"
)

Helpers = dict[sp.Symbol, sp.Expr]


def standard() -> Definition:
    """MMG standard method (Yasukawa & Yoshimura 2015): velocities at midship, S = L d.

    (m + m_x) u_dot - (m + m_y) v r - x_G m r^2 = X_H + X_R + X_P
    (m + m_y) v_dot + (m + m_x) u r + x_G m r_dot = Y_H + Y_R
    (I_zz + J_z) r_dot + x_G m (v_dot + u r) = N_H + N_R,    I_zz about midship

    The wake (C_2) and the flow straightening (gamma_R) differ between port and starboard inflow.
    """
    u, v, r, _, _, _ = states = symbols("u v r x y psi")
    delta, n = inputs = symbols("delta n")
    coefficients, c = _named(STANDARD_COEFFICIENTS)
    constants, k = _named(STANDARD_CONSTANTS.split())
    length, area = k["L"], k["L"] * k["d"]
    mass, inertia = 2 * k["nabla"] / (area * length), 2 * k["I_zz"] / (k["rho"] * area * length**3)

    helpers, speed, (_, vp, rp), q = _instantaneous(u, v, r, length)
    thrust, ur, vr = _standard_inflow(helpers, k, (u, v, rp, speed), n, area * length)
    rudder = _rudder(helpers, delta, ur, vr, k["A_R"] * k["f_alpha"] / (area * length), c)

    hull = {axis: _polynomial(c, f"{axis}_", terms, {"v": vp, "r": rp}) * q for axis, terms in STANDARD.items()}
    surge = hull["X"] - c["R_0"] * q + (1 - k["t_P"]) * thrust + rudder[0]
    gyration = k["x_G"] * mass
    return Definition(
        name="mmg",
        title="3-DOF MMG standard method",
        states=states,
        inputs=inputs,
        coefficients=coefficients,
        constants=constants,
        mass=_mass(mass + k["m_x"], mass + k["m_y"], (inertia + k["J_z"]) * length, gyration, gyration / length),
        forces=[
            surge + (mass + k["m_y"]) * v * r + gyration * r**2,
            hull["Y"] + rudder[1] - (mass + k["m_x"]) * u * r,
            hull["N"] + rudder[2] - gyration * u * r / length,
        ],
        kinematics=_kinematics(states),
        helpers=helpers,
        units={name: "1" for name in STANDARD_COEFFICIENTS},
        force_scale=_force_scale(k["rho"], area * length, length),
        source="Yasukawa & Yoshimura 2015, doi 10.1007/s00773-014-0293-y",
    )


def _standard_inflow(helpers: Helpers, k: Mapping[str, sp.Symbol], motion, n, scale):
    """Thrust, and the velocities u_R, v_R at the rudder; `motion` is u, v, r' and U, `scale` is S L."""
    u, v, rp, speed = motion
    beta, beta_p, water, slip, beta_r, ur, vr = symbols("beta beta_P wake_factor u_slip beta_R u_R v_R")
    helpers[beta] = -sp.S.One * atan2v(v, u)
    helpers[beta_p] = beta - k["x_P"] * rp
    c_2 = _sided(beta_p, k["C_2_plus"], k["C_2_minus"])
    helpers[water] = (1 - k["w_P0"]) * (1 + (1 - sp.exp(-k["C_1"] * absv(beta_p))) * (c_2 - 1))
    up, thrust = _propeller(helpers, u * water, n * k["D_P"], k["D_P"], (k["k_0"], k["k_1"], k["k_2"]), scale)
    helpers[slip], helpers[ur] = _slipstream(k, up, sp.sqrt(_race_square(up, thrust, k["D_P"], scale) + AT_REST), slip)
    helpers[beta_r] = beta - k["l_R"] * rp
    helpers[vr] = -speed * _sided(beta_r, k["gamma_R_plus"], k["gamma_R_minus"]) * beta_r
    return thrust, ur, vr


def _slipstream(k: Mapping[str, sp.Symbol], up, race, slip) -> tuple[sp.Expr, sp.Expr]:
    """Velocity in the race at the rudder, which gets the symbol `slip`, and mean velocity u_R over the rudder."""
    eta = k["D_P"] / k["H_R"]
    return up + k["kappa"] * (race - up), k["epsilon"] * sp.sqrt(eta * slip**2 + (1 - eta) * up**2 + AT_REST)


def low_speed() -> Definition:
    """MMG with linear lift and cross-flow drag instead of a polynomial in v', r': regular at rest and at any drift.

    The equations of motion are those of `standard`, IJ_z being the moment of inertia about the centre of gravity with
    its added part.  With s = v + C_r r L x', x' from -1/2 to 1/2:
    X_H = -R_0 u U + X_vv v^2 + X_vr v r L + X_rr (r L)^2
    Y_H = Y_v v |u| + Y_r r L u - C_D int |s| s dx'      (C_r = C_rY)
    N_H = N_v v u + N_r r L |u| - C_D int |s| s x' dx'   (C_r = C_rN)
    1 - w_P = 1 - w_P0 + tau |v' + x_P r'| + C_P (v' + x_P r')^2, between 0 and 1.
    v_R = gamma_R (v + l_R r L), gamma_R_plus where the rudder moves to port through the water.
    Reversed propellers have the thrust curve of the forward ones with the sign of the revolutions.
    """
    u, v, r, _, _, _ = states = symbols("u v r x y psi")
    delta, n = inputs = symbols("delta n")
    coefficients, c = _named(LOW_SPEED_COEFFICIENTS)
    constants, k = _named(LOW_SPEED_CONSTANTS.split())
    length, area = k["L"], k["L"] * k["d"]
    mass, gyration = 2 * k["nabla"] / (area * length), k["x_G"] * 2 * k["nabla"] / (area * length)
    inertia = (k["IJ_z"] + mass * (k["x_G"] / length) ** 2) * length

    speed, turn = symbols("U rL")
    helpers: Helpers = {speed: sp.sqrt(u**2 + v**2 + AT_REST), turn: r * length}
    thrust, ur, vr = _low_speed_inflow(helpers, k, (u, v, speed, turn), n, area * length)
    rudder = _rudder(helpers, delta, ur, vr, k["A_R"] * k["f_alpha"] / (area * length), c)
    across, about = _cross_flow(helpers, v, turn, (k["C_rY"], k["C_rN"]))

    drag = c["X_vv"] * v**2 + c["X_vr"] * v * turn + c["X_rr"] * turn**2 - c["R_0"] * u * speed
    side = c["Y_v"] * v * absv(u) + c["Y_r"] * turn * u - c["C_D"] * across
    moment = c["N_v"] * v * u + c["N_r"] * turn * absv(u) - c["C_D"] * about
    return Definition(
        name="mmg-low-speed",
        title="3-DOF MMG with cross-flow drag, for starts from rest and large drift",
        states=states,
        inputs=inputs,
        coefficients=coefficients,
        constants=constants,
        mass=_mass(mass + k["m_x"], mass + k["m_y"], inertia, gyration, gyration / length),
        forces=[
            drag / length + (1 - k["t_P"]) * thrust + rudder[0] + (mass + k["m_y"]) * v * r + gyration * r**2,
            side / length + rudder[1] - (mass + k["m_x"]) * u * r,
            moment / length + rudder[2] - gyration * u * r / length,
        ],
        kinematics=_kinematics(states),
        helpers=helpers,
        units={name: "1" for name in LOW_SPEED_COEFFICIENTS},
        force_scale=_force_scale(k["rho"], area * length, length),
        source="Yoshimura, Nakao & Ishibashi 2009 (MARSIM); Miyauchi et al. 2022, doi 10.1007/s00773-022-00889-3",
    )


def _low_speed_inflow(helpers: Helpers, k: Mapping[str, sp.Symbol], motion, n, scale):
    """Thrust, and the velocities u_R, v_R at the rudder; `motion` is u, v, U and r L, `scale` is S L."""
    u, v, speed, turn = motion
    stern, water, slip, across, ur, vr = symbols("v_stern wake_factor u_slip v_rudder u_R v_R")
    helpers[stern] = (v + k["x_P"] * turn) / speed
    open_water = 1 - k["w_P0"] + k["tau"] * _rounded(stern, ROUNDED) + k["C_P"] * stern**2
    inner, outer = (cast("sp.Expr", absv(value)) for value in (open_water, open_water - 1))
    helpers[water] = (inner - outer + 1) / 2
    up, thrust = symbols("u_P thrust")
    tip = n * k["D_P"]
    helpers[up] = u * water
    curve = k["k_0"] * tip * absv(tip) + k["k_1"] * absv(tip) * up + k["k_2"] * up**2
    helpers[thrust] = 2 * k["D_P"] ** 2 / scale * curve
    square = _race_square(up, thrust, k["D_P"], scale)
    helpers[slip], helpers[ur] = _slipstream(k, up, sp.sqrt((square + absv(square)) / 2 + AT_REST), slip)
    helpers[across] = v + k["l_R"] * turn
    mean, half = (k["gamma_R_plus"] + k["gamma_R_minus"]) / 2, (k["gamma_R_plus"] - k["gamma_R_minus"]) / 2
    helpers[vr] = mean * across - half * _rounded(across, ROUNDED * speed)
    return thrust, ur, vr


def _rounded(value, width) -> sp.Expr:
    """|value| with its kink rounded over `width`, zero at zero."""
    return sp.sqrt(value**2 + width**2) - width


def _cross_flow(helpers: Helpers, v, turn, levers) -> tuple[sp.Expr, sp.Expr]:
    """Integrals over the hull of |s| s and of |s| s x', s = v + C_r r L x', with C_r from `levers`."""
    places, weights = np.polynomial.legendre.leggauss(STATIONS)
    sums: list[sp.Expr] = []
    for name, lever, power in zip("YN", levers, (0, 1), strict=True):
        total = sp.S.Zero
        for i, (place, weight) in enumerate(zip(places / 2, weights / 2, strict=True)):
            flow = sp.Symbol(f"cross_{name}{i}", real=True)
            helpers[flow] = v + lever * sp.Float(place) * turn
            total += sp.Float(weight * place**power) * absv(flow) * flow
        sums.append(total)
    return sums[0], sums[1]


def son_nomoto() -> Definition:
    """Son & Nomoto 1982 with roll locked: primes by the instantaneous speed, sway-yaw added-mass coupling kept."""
    return _container(
        "mmg-son-nomoto", "3-DOF MMG, derivatives non-dimensional by the instantaneous speed", fixed=False
    )


def fixed_speed() -> Definition:
    """The same ship in paper 004's structure: hull polynomial in u/U0, v/U0, r L/U0, no sway-yaw coupling (eq 1)."""
    return _container("mmg-fixed-speed", "3-DOF MMG, derivatives non-dimensional by the initial speed", fixed=True)


def _container(name: str, title: str, fixed: bool) -> Definition:
    """Paper 004, eq 1-13 with the corrections of its errata; S = L^2; propeller and rudder of Son & Nomoto 1982."""
    u, v, r, _, _, _ = states = symbols("u v r x y psi")
    delta, n = inputs = symbols("delta n")
    coefficients, c = _named(SON_NOMOTO_COEFFICIENTS)
    constants, k = _named([*SON_NOMOTO_CONSTANTS.split(), "U0" if fixed else "alpha_y"])
    length = k["L"]
    scale = length**3
    lever = sp.S.Zero if fixed else k["m_y"] * k["alpha_y"]

    helpers, speed, (up, vp, rp), q = _instantaneous(u, v, r, length)
    stern, ur, vr = symbols("v_stern u_R v_R")
    helpers[stern] = vp + k["x_P"] * rp
    inflow = u * (1 - k["w_P"] + k["tau"] * stern**2)
    u_p, thrust = _propeller(helpers, inflow, n * k["D_P"], k["D_P"], (k["a_0"], k["a_1"], k["a_2"]), scale)
    helpers[ur] = k["epsilon"] * sp.sqrt(_race_square(u_p, k["k_x"] * thrust, k["D_P"], scale))
    helpers[vr] = speed * (k["gamma_R"] * vp + k["c_Rr"] * rp + k["c_Rrrr"] * rp**3 + k["c_Rrrv"] * rp**2 * vp)
    rudder = _rudder(helpers, delta, ur, vr, k["A_R"] * k["f_alpha"] / scale, c)

    letters = {"u": up, "v": vp, "r": rp}
    if fixed:
        letters, q = _fixed(helpers, u, v, r, length, k["U0"])
    hull = [_polynomial(c, axis, terms, letters) * q for axis, terms in (("X", SURGE), ("Y", SWAY), ("N", SWAY))]
    return Definition(
        name=name,
        title=title,
        states=states,
        inputs=inputs,
        coefficients=coefficients,
        constants=constants,
        mass=_mass(k["m"] + k["m_x"], k["m"] + k["m_y"], (k["I_z"] + k["J_z"]) * length, lever * length, lever),
        forces=[
            hull[0] + c["CP"] * thrust + rudder[0] + (k["m"] + k["m_y"]) * v * r,
            hull[1] + rudder[1] - (k["m"] + k["m_x"]) * u * r,
            hull[2] + rudder[2],
        ],
        kinematics=_kinematics(states),
        helpers=helpers,
        units={coefficient: "1" for coefficient in SON_NOMOTO_COEFFICIENTS},
        force_scale=_force_scale(sp.Symbol("rho", real=True), scale, length),
        source="Son & Nomoto 1982 (MSS container.m, roll locked); paper 004, eq 1-13",
    )


def _named(names: Sequence[str]) -> tuple[list[sp.Symbol], dict[str, sp.Symbol]]:
    made = symbols(" ".join(names))
    return made, dict(zip(names, made, strict=True))


def _instantaneous(u, v, r, length) -> tuple[Helpers, sp.Symbol, list[sp.Symbol], sp.Symbol]:
    """Speed, u' = u/U, v' = v/U, r' = r L/U and q = U^2/L."""
    speed, inverse, up, vp, rp, q = symbols("U iU up vp rp q")
    helpers: Helpers = {
        speed: sp.sqrt(u**2 + v**2 + sp.Float(1e-12)),
        inverse: 1 / speed,
        up: u * inverse,
        vp: v * inverse,
        rp: r * length * inverse,
        q: speed**2 / length,
    }
    return helpers, speed, [up, vp, rp], q


def _fixed(helpers: Helpers, u, v, r, length, speed0) -> tuple[dict[str, sp.Symbol], sp.Symbol]:
    """u/U0, v/U0, r L/U0 and q = U0^2/L for the hull polynomial; adds their helpers."""
    up, vp, rp, q = symbols("up_0 vp_0 rp_0 q_0")
    helpers |= {up: u / speed0, vp: v / speed0, rp: r * length / speed0, q: speed0**2 / length}
    return {"u": up, "v": vp, "r": rp}, q


def _polynomial(coefficients: Mapping[str, sp.Symbol], prefix: str, terms: Sequence[str], letters) -> sp.Expr:
    """Sum of coefficient times monomial; `v_absr` stands for v|r|."""
    total = sp.S.Zero
    for term in terms:
        plain, _, absolute = term.partition("_abs")
        factors = [letters[letter] for letter in plain] + [absv(letters[letter]) for letter in absolute]
        total += coefficients[prefix + term] * sp.prod(factors)
    return total


def _propeller(helpers: Helpers, inflow, tip, diameter, polynomial, scale) -> tuple[sp.Symbol, sp.Symbol]:
    """Inflow u_P and thrust T = rho n^2 D^4 K_T per 0.5 rho S L; `tip` is n D, `scale` is S L."""
    up, thrust = symbols("u_P thrust")
    k0, k1, k2 = polynomial
    helpers[up] = inflow
    helpers[thrust] = 2 * diameter**2 / scale * (k0 * tip**2 + k1 * tip * up + k2 * up**2)
    return up, thrust


def _race_square(up, thrust, diameter, scale) -> sp.Expr:
    """Squared velocity far behind the propeller, u_P^2 (1 + 8 K_T/(pi J^2)), from the thrust per 0.5 rho S L."""
    return up**2 + sp.Float(4 / math.pi) * scale / diameter**2 * thrust


def _rudder(helpers: Helpers, delta, ur, vr, factor, coefficients) -> list[sp.Expr]:
    """Surge force, sway force and yaw moment of the rudder (paper 004, eq 7, 8 and 13).

    `vr` is the sway velocity of the rudder through the water; `factor` is A_R f_alpha/(S L).  The inflow has the angle
    alpha_R = delta + atan(v_R/u_R) and the speed U_R: U_R sin(alpha_R) = u_R sin(delta) + v_R cos(delta).
    """
    normal, sine, cosine = symbols("F_N sin_delta cos_delta")
    helpers[sine], helpers[cosine] = sp.sin(delta), sp.cos(delta)
    helpers[normal] = factor * sp.sqrt(ur**2 + vr**2) * (ur * sine + vr * cosine)
    along, across, moment = (coefficients[name] for name in RUDDER)
    return [-along * normal * sine, -across * normal * cosine, -moment * normal * cosine]


def _sided(angle, plus, minus) -> sp.Expr:
    """`plus` where the angle is positive, else `minus` (both multiply a function that vanishes at 0)."""
    return minus + (plus - minus) * step(angle)


def _mass(surge, sway, yaw, yaw_into_sway, sway_into_yaw) -> sp.Matrix:
    return sp.Matrix([[surge, 0, 0], [0, sway, yaw_into_sway], [0, sway_into_yaw, yaw]])


def _force_scale(rho, scale, length) -> list[sp.Expr]:
    """1/(0.5 rho S L) for the forces, 1/(0.5 rho S L^2) for the moment; `scale` is S L."""
    force = 2 / (rho * scale)
    return [force, force, force / length]


def _kinematics(states) -> list[sp.Expr]:
    u, v, r, _, _, psi = states
    return [u * sp.cos(psi) - v * sp.sin(psi), u * sp.sin(psi) + v * sp.cos(psi), r]


DEFINITIONS = {
    "mmg": standard,
    "mmg-low-speed": low_speed,
    "mmg-son-nomoto": son_nomoto,
    "mmg-fixed-speed": fixed_speed,
}
