"""Response models: yaw rate and heading driven by the rudder (Nomoto, K-T; papers 000, 002 and 003).

All are integrated and fitted in the coefficients of the highest derivative, which stay finite and keep their
sign free for a course-unstable ship (1/T passes through zero); K, T1, T2, ... are published from them.
"""

from __future__ import annotations

import sympy as sp

from ..definition import Definition, symbols
from ..primitives import absv

DAMPING = {"": None, "-cubic": lambda r: r**3, "-quadratic": lambda r: r * absv(r)}
ALPHA_UNITS = {"-cubic": "s2/rad2", "-quadratic": "s/rad"}


def first_order(suffix: str) -> Definition:
    """T r_dot + r + alpha d(r) = K delta, integrated as r_dot = a r + b delta + c d(r)."""
    r, psi = symbols("r psi")
    (delta,) = symbols("delta")
    a, b, c = symbols("a b c")
    big_t, gain, alpha = symbols("T K alpha")
    damping = DAMPING[suffix]
    force = a * r + b * delta
    public = {"T": -1 / a, "K": -b / a}
    inverse = {"a": -1 / big_t, "b": gain / big_t}
    if damping is not None:
        force += c * damping(r)
        public["alpha"] = c / a
        inverse["c"] = -alpha / big_t
    return Definition(
        name="nomoto-1" + suffix,
        title=f"first-order Nomoto{_spoken(suffix)}",
        states=[r, psi],
        inputs=[delta],
        coefficients=[a, b] if damping is None else [a, b, c],
        constants=[],
        mass=sp.eye(1),
        forces=[force],
        kinematics=[r],
        public=public,
        inverse=inverse,
        units=_select({"T": "s", "K": "1/s", "alpha": ALPHA_UNITS.get(suffix, "")}, public),
        source="Nomoto et al. 1957; paper 002, eq 1",
        linear=damping is None,
    )


def second_order(suffix: str) -> Definition:
    """h r_ddot + g r_dot + r + alpha d(r) = K delta + K T3 delta_rate.

    Integrated as r_ddot = a1 r_dot + a2 r + a3 d(r) + b1 delta + b2 delta_rate.  The linear form is published as
    T1, T2 (h = T1 T2, g = T1 + T2), nan where they are complex; the others as h, g, which paper 002 uses.
    """
    q, r, psi = symbols("q r psi")
    delta, rate = symbols("delta delta_rate")
    a1, a2, a3, b1, b2 = symbols("a1 a2 a3 b1 b2")
    damping = DAMPING[suffix]
    if damping is None:
        coefficients = [a1, a2, b1, b2]
        public, inverse, units = _time_constants(a1, a2, b1, b2)
    else:
        coefficients = [a1, a2, a3, b1, b2]
        h, g, alpha, t3, gain = symbols("h g alpha T3 K")
        public = {"h": -1 / a2, "g": a1 / a2, "alpha": a3 / a2, "T3": b2 / b1, "K": -b1 / a2}
        inverse = {"a1": -g / h, "a2": -1 / h, "a3": -alpha / h, "b1": gain / h, "b2": gain * t3 / h}
        units = {"h": "s2", "g": "s", "alpha": ALPHA_UNITS[suffix], "T3": "s", "K": "1/s"}
    return Definition(
        name="nomoto-2" + suffix,
        title=f"second-order Nomoto{_spoken(suffix)}",
        states=[q, r, psi],
        inputs=[delta, rate],
        coefficients=coefficients,
        constants=[],
        mass=sp.eye(1),
        forces=[a1 * q + a2 * r + b1 * delta + b2 * rate + (0 if damping is None else a3 * damping(r))],
        kinematics=[q, r],
        public=public,
        inverse=inverse,
        units=units,
        rate_gain=b2,
        source="Nomoto et al. 1957; paper 002, eq 4; paper 003, eq 1 and 31",
        linear=damping is None,
    )


def second_order_speed() -> Definition:
    """Second-order Nomoto with quadratic damping whose rudder moment goes with the speed U(t) to the power m.

    h r_ddot + g r_dot + r + alpha r|r| = K (delta + delta0) U^m + K T3 delta_rate, with the measured U in m/s (K is
    the gain at 1 m/s) and a neutral rudder angle -delta0.  At constant propeller speed the slipstream keeps the
    rudder's inflow from falling with the ship's speed, so m is well below the 2 of a rudder in open water.
    """
    q, r, psi = symbols("q r psi")
    delta, rate, speed = symbols("delta delta_rate speed")
    a1, a2, a3, b0, b1, b2, m = symbols("a1 a2 a3 b0 b1 b2 m")
    h, g, alpha, t3, gain, offset = symbols("h g alpha T3 K delta0")
    return Definition(
        name="nomoto-2-quadratic-speed",
        title="second-order Nomoto with quadratic damping, rudder offset and measured speed",
        states=[q, r, psi],
        inputs=[delta, rate, speed],
        coefficients=[a1, a2, a3, b0, b1, b2, m],
        constants=[],
        mass=sp.eye(1),
        forces=[a1 * q + a2 * r + a3 * r * absv(r) + (b0 + b1 * delta) * speed**m + b2 * rate],
        kinematics=[q, r],
        public={
            **{"h": -1 / a2, "g": a1 / a2, "alpha": a3 / a2, "T3": b2 / b1, "K": -b1 / a2},
            **{"delta0": b0 / b1, "m": m},
        },
        inverse={
            **{"a1": -g / h, "a2": -1 / h, "a3": -alpha / h, "b0": gain * offset / h, "b1": gain / h},
            **{"b2": gain * t3 / h, "m": m},
        },
        units={
            **{"h": "s2", "g": "s", "alpha": "s/rad", "T3": "s", "K": "1/s at 1 m/s"},
            **{"delta0": "rad", "m": "1"},
        },
        rate_gain=b2,
        held=[m],
        source="this project, from the residuals of KVLCC2 free-running zigzags",
    )


def _time_constants(a1, a2, b1, b2):
    """T1 >= T2 from the characteristic polynomial (paper 003, eq 31 corrected)."""
    t1, t2, t3, gain = symbols("T1 T2 T3 K")
    root = sp.sqrt((a1 / a2) ** 2 + 4 / a2)
    public = {"T1": (a1 / a2 + root) / 2, "T2": (a1 / a2 - root) / 2, "T3": b2 / b1, "K": -b1 / a2}
    inverse = {
        "a1": -(t1 + t2) / (t1 * t2),
        "a2": -1 / (t1 * t2),
        "b1": gain / (t1 * t2),
        "b2": gain * t3 / (t1 * t2),
    }
    return public, inverse, {"T1": "s", "T2": "s", "T3": "s", "K": "1/s"}


def kt() -> Definition:
    """r_ddot + T1 r_dot + T2 r = K delta + T3 delta_rate: the four-parameter K-T equation of paper 000, eq 5."""
    q, r, psi = symbols("q r psi")
    delta, rate = symbols("delta delta_rate")
    t1, t2, gain, t3 = coefficients = symbols("T1 T2 K T3")
    return Definition(
        name="kt",
        title="four-parameter K-T equation",
        states=[q, r, psi],
        inputs=[delta, rate],
        coefficients=coefficients,
        constants=[],
        mass=sp.eye(1),
        forces=[-t1 * q - t2 * r + gain * delta + t3 * rate],
        kinematics=[q, r],
        units={"T1": "1/s", "T2": "1/s2", "K": "1/s3", "T3": "1/s2"},
        rate_gain=t3,
        source="paper 000, eq 5",
        linear=True,
    )


def integrator() -> Definition:
    """r_dot = k delta: the baseline that any identified model must improve on."""
    r, psi = symbols("r psi")
    (delta,) = symbols("delta")
    (k,) = symbols("k")
    return Definition(
        name="integrator",
        title="yaw rate as the integral of the rudder (baseline)",
        states=[r, psi],
        inputs=[delta],
        coefficients=[k],
        constants=[],
        mass=sp.eye(1),
        forces=[k * delta],
        kinematics=[r],
        units={"k": "1/s2"},
        source="limit of first-order Nomoto for T -> infinity",
        linear=True,
    )


def steered() -> Definition:
    """Second-order Nomoto with a first-order steering gear and a heading P-controller (paper 003, eq 3-6 corrected).

    delta_dot = (-delta + kp (psi_set - psi))/Tm, and the rudder rate enters the yaw equation through T3.
    The input is the heading reference.
    """
    q, r, psi, delta = symbols("q r psi rudder")
    (reference,) = symbols("delta")
    a1, a2, b1, b2 = coefficients = symbols("a1 a2 b1 b2")
    gain, lag = symbols("kp Tm")
    rate = (gain * (reference - psi) - delta) / lag
    public, inverse, units = _time_constants(a1, a2, b1, b2)
    return Definition(
        name="nomoto-2-steered",
        title="second-order Nomoto with steering gear and heading P-controller",
        states=[q, r, psi, delta],
        inputs=[reference],
        coefficients=coefficients,
        constants=[gain, lag],
        mass=sp.eye(1),
        forces=[a1 * q + a2 * r + b1 * delta + b2 * rate],
        kinematics=[q, r, rate],
        public=public,
        inverse=inverse,
        units=units,
        source="paper 003, eq 3-6 with the corrections of its errata",
        linear=True,
    )


def _spoken(suffix: str) -> str:
    return f" with {suffix[1:]} damping" if suffix else ""


def _select(units: dict[str, str], public: dict) -> dict[str, str]:
    return {name: units[name] for name in public}


DEFINITIONS = {
    "integrator": integrator,
    **{f"nomoto-1{suffix}": (lambda s=suffix: first_order(s)) for suffix in DAMPING},
    **{f"nomoto-2{suffix}": (lambda s=suffix: second_order(s)) for suffix in DAMPING},
    "nomoto-2-quadratic-speed": second_order_speed,
    "nomoto-2-steered": steered,
    "kt": kt,
}
