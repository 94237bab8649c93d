"""3-DOF Abkowitz model with instantaneous-speed primes (Chislett & Stroem-Tejsen 1965; paper 001)."""

from __future__ import annotations

from ..definition import PLANE, PLANE_RATES, Definition, written

SURGE = "Xu Xuu Xuuu Xvv Xrr Xdd Xddu Xvr Xvd Xvdu Xuvv Xurr Xuvr Xrd Xurd X0"
SWAY = "u uu v r d vvv ddd vvr vvd vdd du vu ru duu rrr vrr vuu ruu rdd rrd rvd 0"
COEFFICIENTS = SURGE.split() + [force + term for force in "YN" for term in SWAY.split()]
LETTERS = {"u": "up", "v": "vp", "r": "rp", "d": "delta", "0": "1"}
"""Letter of a coefficient's name -> the factor that it stands for."""


def abkowitz() -> Definition:
    """M a = U^2/L {X, Y, N/L}: polynomials in u' = (u - U0)/U, v' = v/U, r' = r L/U and the rudder angle."""
    terms = {name: "*".join([name, *(LETTERS[letter] for letter in name[1:])]) for name in COEFFICIENTS}
    sums = (" + ".join(term for name, term in terms.items() if name[0] == axis) for axis in "XYN")
    return written(
        name="abkowitz",
        title="3-DOF Abkowitz polynomial",
        states=PLANE,
        inputs="delta",
        coefficients=" ".join(COEFFICIENTS),
        constants="L U0 m11 m22 m23 m32 m33",
        mass=[["m11", "0", "0"], ["0", "m22", "m23*L"], ["0", "m32", "m33*L"]],
        forces=[f"({total})*q" for total in sums],
        kinematics=PLANE_RATES,
        helpers={
            "U": "sqrt(u**2 + v**2 + 1e-12)",
            "iU": "1/U",
            "up": "(u - U0)*iU",
            "vp": "v*iU",
            "rp": "r*L*iU",
            "q": "U**2/L",
        },
        units=dict.fromkeys(COEFFICIENTS, "1"),
        force_scale=["2/(rho*L**3)", "2/(rho*L**3)", "2/(rho*L**4)"],
        source="Chislett & Stroem-Tejsen 1965; paper 001",
    )


DEFINITIONS = {"abkowitz": abkowitz}
