"""Linear sway-yaw model at a constant surge speed (Prestero's REMUS derivatives; paper 000, Table 1)."""

from __future__ import annotations

from ..definition import PLANE, PLANE_RATES, Definition, written

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
    return written(
        name="sway-yaw",
        title="linear sway and yaw at constant surge speed",
        states=PLANE,
        inputs="delta",
        coefficients=" ".join(COEFFICIENTS),
        constants="m xG Iz Yvdot Yrdot Nvdot Nrdot",
        mass=[["1", "0", "0"], ["0", "m - Yvdot", "m*xG - Yrdot"], ["0", "m*xG - Nvdot", "Iz - Nrdot"]],
        forces=[
            "0",
            "Yuv*u*v + (Yur - m)*u*r + Yuud*u**2*delta",
            "Nuv*u*v + (Nur - m*xG)*u*r + Nuud*u**2*delta",
        ],
        kinematics=PLANE_RATES,
        units=COEFFICIENTS,
        force_scale=["0", "1", "1"],
        source="paper 000, eq 1-4 with the corrections of its errata; Prestero 2001",
    )


DEFINITIONS = {"sway-yaw": sway_yaw}
