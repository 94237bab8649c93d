"""A first-order yaw response with drift and speed loss: the least that has the indices of IMO MSC.137(76).

In primes of the instantaneous speed U and the length L, with the speed U0 of the straight course,

    r_dot' = -damping r' - cubic r'^3 + gain ((1 - race) + race (U0/U)^2) delta        Nomoto 1960, Norrbin 1963
    u_dot' = surge ((U0/U)^2 - u|u|/U^2 - speed_loss r'^2 u/U)
    s_dot' = -0.7 s',  s = v + pivot L r

1/damping is T' and gain/damping K'; a ship with negative damping is unstable on a straight course.  The moment of a
rudder in a propeller's race falls less than U^2 (share `race`, as in families/steering.py).  Thrust less resistance
balances U0; the resistance of a turn goes with r'^2, as drift and centripetal force do.  The hull turns about a point
`pivot` lengths ahead of the reference point, v = -pivot L r; sway by forces from outside dies away.
"""

from __future__ import annotations

from ..definition import PLANE, PLANE_RATES, Definition, written

FULLNESS = 0.008
SWAY_DAMPING, ADDED = 0.7, 2.0
"""About those of merchant ships; indices do not depend on them: displaced volume over L^3, damping of sway by forces
from outside, and mass in sway and inertia in yaw with the added ones over those without."""


def response() -> Definition:
    """Coefficients a = -damping, b and bn of the rudder, c = -cubic, p = pivot, s = surge and w = surge speed_loss."""
    mass = f"rho*{FULLNESS}*L**3"
    return written(
        name="turning-response",
        title="first-order yaw response with drift and speed loss",
        states=PLANE,
        inputs="delta",
        coefficients="a b bn c p s w",
        constants="L U0",
        mass=[["1", "0", "0"], ["0", "1", "p*L"], ["0", "0", "1"]],
        forces=[
            "(s*(U0**2 - u*absv(u)) - w*(r*L)**2*u/U)/L",
            f"-{SWAY_DAMPING}*U/L*v - {SWAY_DAMPING}*p*U*r",
            "a*U/L*r + (b*U**2 + bn*U0**2)/L**2*delta + c*L/U*r**3",
        ],
        kinematics=PLANE_RATES,
        helpers={"U": "sqrt(u**2 + v**2 + 1e-12)"},
        public={
            **{"damping": "-a", "gain": "b + bn", "race": "bn/(b + bn)", "cubic": "-c"},
            **{"pivot": "p", "surge": "s", "speed_loss": "w/s"},
        },
        inverse={
            **{"a": "-damping", "b": "gain*(1 - race)", "bn": "gain*race", "c": "-cubic"},
            **{"p": "pivot", "s": "surge", "w": "surge*speed_loss"},
        },
        units=dict.fromkeys(("damping", "gain", "race", "cubic", "pivot", "surge", "speed_loss"), "1") | {"pivot": "L"},
        force_scale=[f"1/({mass})", f"1/({ADDED}*{mass})", f"1/({ADDED}*{mass}*(L/4)**2)"],
        source="Nomoto 1960 and Norrbin 1963 in primes; drift about a fixed point, speed loss and race: this project",
    )


DEFINITIONS = {"turning-response": response}
