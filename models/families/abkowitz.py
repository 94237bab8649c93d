"""3-DOF Abkowitz model with instantaneous-speed primes (Chislett & Stroem-Tejsen 1965; paper 001)."""

from __future__ import annotations

import sympy as sp

from ..definition import Definition, symbols

SURGE = "Xu Xuu Xuuu Xvv Xrr Xdd Xddu Xvr Xvd Xvdu Xuvv Xurr Xuvr Xrd Xurd X0"
SWAY = "u uu v r d vvv ddd vvr vvd vdd du vu ru duu rrr vrr vuu ruu rdd rrd rvd 0"
COEFFICIENTS = SURGE.split() + [force + term for force in "YN" for term in SWAY.split()]


def abkowitz() -> Definition:
    """M a = U^2/L {X, Y, N/L}: polynomials in u' = (u - U0)/U, v' = v/U, r' = r L/U and the rudder angle."""
    u, v, r, _, _, psi = states = symbols("u v r x y psi")
    (delta,) = inputs = symbols("delta")
    coefficients = symbols(" ".join(COEFFICIENTS))
    constants = length, speed0, m11, m22, m23, m32, m33 = symbols("L U0 m11 m22 m23 m32 m33")
    (rho,) = symbols("rho")
    speed, inverse, up, vp, rp, q = symbols("U iU up vp rp q")
    helpers = {
        speed: sp.sqrt(u**2 + v**2 + sp.Float(1e-12)),
        inverse: 1 / speed,
        up: (u - speed0) * inverse,
        vp: v * inverse,
        rp: r * length * inverse,
        q: speed**2 / length,
    }
    letters = {"u": up, "v": vp, "r": rp, "d": delta, "0": sp.S.One}
    force: dict[str, sp.Expr] = {axis: sp.S.Zero for axis in "XYN"}
    for name, coefficient in zip(COEFFICIENTS, coefficients, strict=True):
        force[name[0]] += coefficient * sp.prod([letters[letter] for letter in name[1:]])
    return Definition(
        name="abkowitz",
        title="3-DOF Abkowitz polynomial",
        states=states,
        inputs=inputs,
        coefficients=coefficients,
        constants=constants,
        mass=sp.Matrix([[m11, 0, 0], [0, m22, m23 * length], [0, m32, m33 * length]]),
        forces=[force[axis] * q for axis in "XYN"],
        kinematics=[u * sp.cos(psi) - v * sp.sin(psi), u * sp.sin(psi) + v * sp.cos(psi), r],
        helpers=helpers,
        units={name: "1" for name in COEFFICIENTS},
        force_scale=[2 / (rho * length**3), 2 / (rho * length**3), 2 / (rho * length**4)],
        source="Chislett & Stroem-Tejsen 1965; paper 001",
    )


DEFINITIONS = {"abkowitz": abkowitz}
