"""Linear sway-yaw model at a constant surge speed (Prestero's REMUS derivatives; paper 000, Table 1)."""

from __future__ import annotations

import sympy as sp

from ..definition import Definition, symbols

COEFFICIENTS = {
    "Yuv": "kg/m",
    "Yur": "kg/rad",
    "Yuud": "kg/(m rad)",
    "Nuv": "kg",
    "Nur": "kg m/rad",
    "Nuud": "kg/rad",
}


def sway_yaw() -> Definition:
    """Sway and yaw with dimensional derivatives; surge stays at its initial value.

    (m - Yvdot) v_dot + (m xG - Yrdot) r_dot = Yuv u v + (Yur - m) u r + Yuud u^2 delta
    (m xG - Nvdot) v_dot + (Iz - Nrdot) r_dot = Nuv u v + (Nur - m xG) u r + Nuud u^2 delta
    """
    u, v, r, _, _, psi = states = symbols("u v r x y psi")
    (delta,) = inputs = symbols("delta")
    yuv, yur, yd, nuv, nur, nd = coefficients = symbols(" ".join(COEFFICIENTS))
    m, xg, iz, yvdot, yrdot, nvdot, nrdot = constants = symbols("m xG Iz Yvdot Yrdot Nvdot Nrdot")
    return Definition(
        name="sway-yaw",
        title="linear sway and yaw at constant surge speed",
        states=states,
        inputs=inputs,
        coefficients=coefficients,
        constants=constants,
        mass=sp.Matrix([[1, 0, 0], [0, m - yvdot, m * xg - yrdot], [0, m * xg - nvdot, iz - nrdot]]),
        forces=[
            sp.S.Zero,
            yuv * u * v + (yur - m) * u * r + yd * u**2 * delta,
            nuv * u * v + (nur - m * xg) * u * r + nd * u**2 * delta,
        ],
        kinematics=[u * sp.cos(psi) - v * sp.sin(psi), u * sp.sin(psi) + v * sp.cos(psi), r],
        units=COEFFICIENTS,
        force_scale=[sp.S.Zero, sp.S.One, sp.S.One],
        source="paper 000, eq 1-4 with the corrections of its errata; Prestero 2001",
    )


DEFINITIONS = {"sway-yaw": sway_yaw}
