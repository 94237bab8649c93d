"""3-DOF MMG models: hull, propeller and rudder as separate submodels that interact.

All definitions are written per 0.5 rho S L (forces) and 0.5 rho S L^2 (moment), S = L d or L^2 being the
reference area of the published derivatives: masses are prime values, accelerations stay in SI, and a hull force
is its prime value times q = U^2/L.  The propeller enters as K_T (n D)^2 = k0 (n D)^2 + k1 n D u_P + k2 u_P^2, which
is finite for a stopped propeller and for u = 0, where the advance ratio J is not.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from functools import partial
from typing import Any

import numpy as np

from ..definition import PLANE, PLANE_RATES, Definition, written

AT_REST = "1e-12"
"""Added to squared velocities below a root, (m/s)^2: the derivatives stay finite for a ship at rest."""
SPEED = {"U": f"sqrt(u**2 + v**2 + {AT_REST})"}
PRIMES = SPEED | {"iU": "1/U", "up": "u*iU", "vp": "v*iU", "rp": "r*L*iU", "q": "U**2/L"}
"""Speed, u' = u/U, v' = v/U, r' = r L/U and q = U^2/L."""
RUDDER = ["CRu", "CRv", "CRr"]
RUDDER_FORCES = ("CRu*F_N*sin_delta", "CRv*F_N*cos_delta", "CRr*F_N*cos_delta")
"""Against surge, sway and yaw (paper 004, eq 13)."""

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
MASS = "2*nabla/(L**2*d)"
"""Prime of the mass, S = L d."""

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
SON_NOMOTO = {"X": SURGE, "Y": SWAY, "N": SWAY}
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


def standard() -> Definition:
    """MMG standard method (Yasukawa & Yoshimura 2015): velocities at midship, S = L d.

    (m + m_x) u_dot - (m + m_y) v r - x_G m r^2 = X_H + X_R + X_P
    (m + m_y) v_dot + (m + m_x) u r + x_G m r_dot = Y_H + Y_R
    (I_zz + J_z) r_dot + x_G m (v_dot + u r) = N_H + N_R,    I_zz about midship

    The wake (C_2) and the flow straightening (gamma_R) differ between port and starboard inflow.
    """
    hull = [_polynomial(f"{axis}_", terms, {"v": "vp", "r": "rp"}) for axis, terms in STANDARD.items()]
    return _ship(
        "mmg",
        "3-DOF MMG standard method",
        STANDARD_COEFFICIENTS,
        STANDARD_CONSTANTS,
        PRIMES
        | {
            "beta": "-atan2v(v, u)",
            "beta_P": "beta - x_P*rp",
            "wake_factor": f"(1 - w_P0)*(1 + (1 - exp(-C_1*absv(beta_P)))*({_sided('C_2', 'beta_P')} - 1))",
            "u_P": "u*wake_factor",
            "thrust": _thrust("L**2*d", "k_0*(n*D_P)**2 + k_1*n*D_P*u_P + k_2*u_P**2"),
            **_at_rudder(f"sqrt({_race_square('L**2*d')} + {AT_REST})"),
            "beta_R": "beta - l_R*rp",
            "v_R": f"-U*{_sided('gamma_R', 'beta_R')}*beta_R",
        },
        (f"({hull[0]})*q - R_0*q", f"({hull[1]})*q", f"({hull[2]})*q"),
        "(2*I_zz/(rho*L**4*d) + J_z)*L",
        source="Yasukawa & Yoshimura 2015, doi 10.1007/s00773-014-0293-y",
    )


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
    open_water = f"(1 - w_P0 + tau*{_rounded('v_stern', str(ROUNDED))} + C_P*v_stern**2)"
    square = _race_square("L**2*d")
    flows, (across, about) = _cross_flow()
    return _ship(
        "mmg-low-speed",
        "3-DOF MMG with cross-flow drag, for starts from rest and large drift",
        LOW_SPEED_COEFFICIENTS,
        LOW_SPEED_CONSTANTS,
        SPEED
        | {
            "rL": "r*L",
            "v_stern": "(v + x_P*rL)/U",
            "wake_factor": f"(absv({open_water}) - absv({open_water} - 1) + 1)/2",
            "u_P": "u*wake_factor",
            "thrust": _thrust("L**2*d", "k_0*n*D_P*absv(n*D_P) + k_1*absv(n*D_P)*u_P + k_2*u_P**2"),
            **_at_rudder(f"sqrt(({square} + absv({square}))/2 + {AT_REST})"),
            "v_rudder": "v + l_R*rL",
            "v_R": "(gamma_R_plus + gamma_R_minus)/2*v_rudder"
            f" - (gamma_R_plus - gamma_R_minus)/2*{_rounded('v_rudder', f'{ROUNDED}*U')}",
        },
        (
            "(X_vv*v**2 + X_vr*v*rL + X_rr*rL**2 - R_0*u*U)/L",
            f"(Y_v*v*absv(u) + Y_r*rL*u - C_D*({across}))/L",
            f"(N_v*v*u + N_r*rL*absv(u) - C_D*({about}))/L",
        ),
        f"(IJ_z + {MASS}*(x_G/L)**2)*L",
        flows,
        source="Yoshimura, Nakao & Ishibashi 2009 (MARSIM); Miyauchi et al. 2022, doi 10.1007/s00773-022-00889-3",
    )


def _ship(
    name: str,
    title: str,
    coefficients: Sequence[str],
    constants: str,
    helpers: dict[str, str],
    hull: Sequence[str],
    inertia: str,
    flows: dict[str, str] | None = None,
    **facts: Any,
) -> Definition:
    """The equations of motion of `standard`, S = L d, from forces of the hull and helpers up to the inflow u_R, v_R of
    the rudder; flows : helpers behind those of the rudder."""
    ahead, across, about = RUDDER_FORCES
    return written(
        name=name,
        title=title,
        states=PLANE,
        inputs="delta n",
        coefficients=" ".join(coefficients),
        constants=constants,
        mass=[
            [f"{MASS} + m_x", "0", "0"],
            ["0", f"{MASS} + m_y", f"x_G*{MASS}"],
            ["0", f"x_G*{MASS}/L", inertia],
        ],
        forces=[
            f"{hull[0]} + (1 - t_P)*thrust - {ahead} + ({MASS} + m_y)*v*r + x_G*{MASS}*r**2",
            f"{hull[1]} - {across} - ({MASS} + m_x)*u*r",
            f"{hull[2]} - {about} - x_G*{MASS}*u*r/L",
        ],
        kinematics=PLANE_RATES,
        helpers=helpers | _rudder("L**2*d") | (flows or {}),
        units=dict.fromkeys(coefficients, "1"),
        force_scale=_force_scale("L**2*d"),
        **facts,
    )


def _cross_flow() -> tuple[dict[str, str], list[str]]:
    """Flow s = v + C_r r L x' at stations of the hull, with C_rY and with C_rN, and the integrals over the hull of
    |s| s with the first and of |s| s x' with the other."""
    places, weights = np.polynomial.legendre.leggauss(STATIONS)
    flows, integrals = {}, []
    for axis, power in (("Y", 0), ("N", 1)):
        own = {f"cross_{axis}{i}": float(place) for i, place in enumerate(places / 2)}
        flows |= {flow: f"v + C_r{axis}*({place!r})*rL" for flow, place in own.items()}
        shares = [float(weight * place**power) for place, weight in zip(places / 2, weights / 2, strict=True)]
        integrals.append(" + ".join(f"({x!r})*absv({s})*{s}" for s, x in zip(own, shares, strict=True)))
    return flows, integrals


def _container(name: str, title: str, fixed: bool) -> Definition:
    """Paper 004, eq 1-13 with the corrections of its errata; S = L^2; propeller and rudder of Son & Nomoto 1982 with
    roll locked.

    fixed : hull polynomial in u/U0, v/U0, r L/U0, no sway-yaw coupling (eq 1); else primes by the instantaneous speed,
    and the sway-yaw coupling of the added mass kept.
    """
    of_hull = {"up_0": "u/U0", "vp_0": "v/U0", "rp_0": "r*L/U0", "q_0": "U0**2/L"} if fixed else {}
    up, vp, rp, q = of_hull or ("up", "vp", "rp", "q")
    letters, (ahead, across, about) = {"u": up, "v": vp, "r": rp}, RUDDER_FORCES
    hull = [f"({_polynomial(axis, terms, letters)})*{q}" for axis, terms in SON_NOMOTO.items()]
    lever = "0" if fixed else "m_y*alpha_y"
    return written(
        name=name,
        title=f"3-DOF MMG, derivatives non-dimensional by the {title} speed",
        states=PLANE,
        inputs="delta n",
        coefficients=" ".join(SON_NOMOTO_COEFFICIENTS),
        constants=f"{SON_NOMOTO_CONSTANTS} {'U0' if fixed else 'alpha_y'}",
        mass=[["m + m_x", "0", "0"], ["0", "m + m_y", f"{lever}*L"], ["0", lever, "(I_z + J_z)*L"]],
        forces=[
            f"{hull[0]} + CP*thrust - {ahead} + (m + m_y)*v*r",
            f"{hull[1]} - {across} - (m + m_x)*u*r",
            f"{hull[2]} - {about}",
        ],
        kinematics=PLANE_RATES,
        helpers={
            **PRIMES,
            "v_stern": "vp + x_P*rp",
            "u_P": "u*(1 - w_P + tau*v_stern**2)",
            "thrust": _thrust("L**3", "a_0*(n*D_P)**2 + a_1*n*D_P*u_P + a_2*u_P**2"),
            "u_R": f"epsilon*sqrt({_race_square('L**3', 'k_x*thrust')})",
            "v_R": "U*(gamma_R*vp + c_Rr*rp + c_Rrrr*rp**3 + c_Rrrv*rp**2*vp)",
            **_rudder("L**3"),
            **of_hull,
        },
        units=dict.fromkeys(SON_NOMOTO_COEFFICIENTS, "1"),
        force_scale=_force_scale("L**3"),
        source="Son & Nomoto 1982 (MSS container.m, roll locked); paper 004, eq 1-13",
    )


def _polynomial(prefix: str, terms: Sequence[str], letters: dict[str, str]) -> str:
    """Sum of coefficient times monomial; `v_absr` stands for v|r|."""
    products = []
    for term in terms:
        plain, _, absolute = term.partition("_abs")
        factors = [letters[letter] for letter in plain] + [f"absv({letters[letter]})" for letter in absolute]
        products.append("*".join([prefix + term, *factors]))
    return " + ".join(products)


def _thrust(scale: str, curve: str) -> str:
    """Thrust T = rho n^2 D^4 K_T per 0.5 rho S L; `scale` is S L, `curve` K_T (n D)^2."""
    return f"2*D_P**2/({scale})*({curve})"


def _race_square(scale: str, thrust: str = "thrust") -> str:
    """Squared velocity far behind the propeller, u_P^2 (1 + 8 K_T/(pi J^2)), from the thrust per 0.5 rho S L."""
    return f"(u_P**2 + {4 / math.pi!r}*{scale}/D_P**2*{thrust})"


def _at_rudder(race: str) -> dict[str, str]:
    """Velocity in the race at the rudder, and mean velocity u_R over the rudder."""
    mean = f"D_P/H_R*u_slip**2 + (1 - D_P/H_R)*u_P**2 + {AT_REST}"
    return {"u_slip": f"u_P + kappa*({race} - u_P)", "u_R": f"epsilon*sqrt({mean})"}


def _rudder(scale: str) -> dict[str, str]:
    """Normal force of the rudder (paper 004, eq 7 and 8), `scale` being S L, v_R its sway velocity through the water.

    The inflow has the angle alpha_R = delta + atan(v_R/u_R) and the speed U_R: U_R sin(alpha_R) = u_R sin(delta) + v_R
    cos(delta).
    """
    normal = f"A_R*f_alpha/({scale})*sqrt(u_R**2 + v_R**2)*(u_R*sin_delta + v_R*cos_delta)"
    return {"sin_delta": "sin(delta)", "cos_delta": "cos(delta)", "F_N": normal}


def _rounded(value: str, width: str) -> str:
    """|value| with its kink rounded over `width`, zero at zero."""
    return f"(sqrt({value}**2 + ({width})**2) - {width})"


def _sided(name: str, angle: str) -> str:
    """NAME_plus where the angle is positive, else NAME_minus (both multiply a function that vanishes at 0)."""
    return f"({name}_minus + ({name}_plus - {name}_minus)*step({angle}))"


def _force_scale(scale: str) -> list[str]:
    """1/(0.5 rho S L) for the forces, 1/(0.5 rho S L^2) for the moment; `scale` is S L."""
    return [f"2/(rho*{scale})", f"2/(rho*{scale})", f"2/(rho*{scale}*L)"]


DEFINITIONS = {
    "mmg": standard,
    "mmg-low-speed": low_speed,
    "mmg-son-nomoto": partial(_container, "mmg-son-nomoto", "instantaneous", fixed=False),
    "mmg-fixed-speed": partial(_container, "mmg-fixed-speed", "initial", fixed=True),
}
