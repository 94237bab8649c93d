"""Response models: yaw rate and heading driven by the rudder (Nomoto, K-T; papers 000, 002 and 003).

All are integrated and fitted in the coefficients of the highest derivative, which stay finite and keep their
sign free for a course-unstable ship (1/T passes through zero); K, T1, T2, ... are published from them.
"""

from __future__ import annotations

from functools import partial
from typing import Any

from ..definition import Definition, written

DAMPING = {"": ("", ""), "-cubic": ("r**3", "s2/rad2"), "-quadratic": ("r*absv(r)", "s/rad")}
"""Ending of an identifier -> nonlinear damping d(r), and the unit of its published coefficient alpha."""
FIRST: dict[str, Any] = {"states": "r psi", "inputs": "delta", "kinematics": ["r"]}
SECOND: dict[str, Any] = {"states": "q r psi", "inputs": "delta delta_rate", "kinematics": ["q", "r"]}
ROOT = "sqrt((a1/a2)**2 + 4/a2)"
TIME_CONSTANTS: dict[str, Any] = {
    "public": {"T1": f"(a1/a2 + {ROOT})/2", "T2": f"(a1/a2 - {ROOT})/2", "T3": "b2/b1", "K": "-b1/a2"},
    "inverse": {"a1": "-(T1 + T2)/(T1*T2)", "a2": "-1/(T1*T2)", "b1": "K/(T1*T2)", "b2": "K*T3/(T1*T2)"},
    "units": {"T1": "s", "T2": "s", "T3": "s", "K": "1/s"},
}
"""T1 >= T2 from the characteristic polynomial (paper 003, eq 31 corrected), nan where they are complex."""


def first_order(suffix: str) -> Definition:
    """T r_dot + r + alpha d(r) = K delta, integrated as r_dot = a r + b delta + c d(r)."""
    damping, unit = DAMPING[suffix]
    return written(
        name="nomoto-1" + suffix,
        title=f"first-order Nomoto{_spoken(suffix)}",
        coefficients="a b c" if damping else "a b",
        forces=[f"a*r + b*delta + c*{damping}" if damping else "a*r + b*delta"],
        public={"T": "-1/a", "K": "-b/a"} | ({"alpha": "c/a"} if damping else {}),
        inverse={"a": "-1/T", "b": "K/T"} | ({"c": "-alpha/T"} if damping else {}),
        units={"T": "s", "K": "1/s"} | ({"alpha": unit} if damping else {}),
        source="Nomoto et al. 1957; paper 002, eq 1",
        linear=not damping,
        **FIRST,
    )


def second_order(suffix: str) -> Definition:
    """h r_ddot + g r_dot + r + alpha d(r) = K delta + K T3 delta_rate.

    Integrated as r_ddot = a1 r_dot + a2 r + a3 d(r) + b1 delta + b2 delta_rate.  The linear form is published as
    T1, T2 (h = T1 T2, g = T1 + T2); the others as h, g, which paper 002 uses.
    """
    damping, unit = DAMPING[suffix]
    damped = {
        "public": {"h": "-1/a2", "g": "a1/a2", "alpha": "a3/a2", "T3": "b2/b1", "K": "-b1/a2"},
        "inverse": {"a1": "-g/h", "a2": "-1/h", "a3": "-alpha/h", "b1": "K/h", "b2": "K*T3/h"},
        "units": {"h": "s2", "g": "s", "alpha": unit, "T3": "s", "K": "1/s"},
    }
    return written(
        name="nomoto-2" + suffix,
        title=f"second-order Nomoto{_spoken(suffix)}",
        coefficients="a1 a2 a3 b1 b2" if damping else "a1 a2 b1 b2",
        forces=["a1*q + a2*r + b1*delta + b2*delta_rate" + (f" + a3*{damping}" if damping else "")],
        rate_gain="b2",
        source="Nomoto et al. 1957; paper 002, eq 4; paper 003, eq 1 and 31",
        linear=not damping,
        **SECOND,
        **(damped if damping else TIME_CONSTANTS),
    )


def _spoken(suffix: str) -> str:
    return f" with {suffix[1:]} damping" if suffix else ""


def second_order_speed() -> Definition:
    """Second-order Nomoto with quadratic damping whose rudder moment goes with the speed U(t) to the power m.

    h r_ddot + g r_dot + r + alpha r|r| = K (delta + delta0) U^m + K T3 delta_rate, with the measured U in m/s (K is
    the gain at 1 m/s) and a neutral rudder angle -delta0.  At constant propeller speed the slipstream keeps the
    rudder's inflow from falling with the ship's speed, so m is well below the 2 of a rudder in open water.
    """
    return written(
        name="nomoto-2-quadratic-speed",
        title="second-order Nomoto with quadratic damping, rudder offset and measured speed",
        coefficients="a1 a2 a3 b0 b1 b2 m",
        forces=["a1*q + a2*r + a3*r*absv(r) + (b0 + b1*delta)*speed**m + b2*delta_rate"],
        public={
            **{"h": "-1/a2", "g": "a1/a2", "alpha": "a3/a2", "T3": "b2/b1", "K": "-b1/a2"},
            **{"delta0": "b0/b1", "m": "m"},
        },
        inverse={
            **{"a1": "-g/h", "a2": "-1/h", "a3": "-alpha/h", "b0": "K*delta0/h", "b1": "K/h"},
            **{"b2": "K*T3/h", "m": "m"},
        },
        units={
            **{"h": "s2", "g": "s", "alpha": "s/rad", "T3": "s", "K": "1/s at 1 m/s"},
            **{"delta0": "rad", "m": "1"},
        },
        rate_gain="b2",
        held="m",
        source="this project, from the residuals of KVLCC2 free-running zigzags",
        states="q r psi",
        inputs="delta delta_rate speed",
        kinematics=["q", "r"],
    )


def kt() -> Definition:
    """r_ddot + T1 r_dot + T2 r = K delta + T3 delta_rate: the four-parameter K-T equation of paper 000, eq 5."""
    return written(
        name="kt",
        title="four-parameter K-T equation",
        coefficients="T1 T2 K T3",
        forces=["-T1*q - T2*r + K*delta + T3*delta_rate"],
        units={"T1": "1/s", "T2": "1/s2", "K": "1/s3", "T3": "1/s2"},
        rate_gain="T3",
        source="paper 000, eq 5",
        linear=True,
        **SECOND,
    )


def integrator() -> Definition:
    """r_dot = k delta: the baseline that any identified model must improve on."""
    return written(
        name="integrator",
        title="yaw rate as the integral of the rudder (baseline)",
        coefficients="k",
        forces=["k*delta"],
        units={"k": "1/s2"},
        source="limit of first-order Nomoto for T -> infinity",
        linear=True,
        **FIRST,
    )


def steered() -> Definition:
    """Second-order Nomoto with a first-order steering gear and a heading P-controller (paper 003, eq 3-6 corrected).

    delta_dot = (-delta + kp (psi_set - psi))/Tm, and the rudder rate enters the yaw equation through T3.
    The input is the heading reference.
    """
    rate = "(kp*(delta - psi) - rudder)/Tm"
    return written(
        name="nomoto-2-steered",
        title="second-order Nomoto with steering gear and heading P-controller",
        states="q r psi rudder",
        inputs="delta",
        coefficients="a1 a2 b1 b2",
        constants="kp Tm",
        forces=[f"a1*q + a2*r + b1*rudder + b2*{rate}"],
        kinematics=["q", "r", rate],
        source="paper 003, eq 3-6 with the corrections of its errata",
        linear=True,
        **TIME_CONSTANTS,
    )


DEFINITIONS = {
    "integrator": integrator,
    **{f"nomoto-1{suffix}": partial(first_order, suffix) for suffix in DAMPING},
    **{f"nomoto-2{suffix}": partial(second_order, suffix) for suffix in DAMPING},
    "nomoto-2-quadratic-speed": second_order_speed,
    "nomoto-2-steered": steered,
    "kt": kt,
}
