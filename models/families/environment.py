"""What acts on a craft from outside, as further inputs of a definition.

The environment variant of a 3-DOF definition has, in this order: current north and east [m/s, towards], wind north and
east [m/s, towards], and body-fixed forces X [N], Y [N], N [N m].  The pushed variant of a response model has a yaw
acceleration in the units of its highest derivative.  With all of them zero a variant equals the calm definition.
"""

from __future__ import annotations

from dataclasses import replace

import sympy as sp

from ..definition import Definition, symbols
from ..kernels import ENVIRONMENT, PUSHED
from ..primitives import absv, atan2v

INPUTS = "current_north current_east wind_north wind_east force_x force_y moment_n"
CONSTANTS = "rho rho_air A_F A_L wind_cx wind_cy wind_cn wind_kn wind_delta wind_L"


def with_environment(definition: Definition, wind: bool = True) -> Definition:
    """Current as a change of the velocities the hull feels, wind (unless left out) and extra forces as additions.

    The calm equations hold for velocities relative to the water; with a steady, uniform current the
    ground-relative accelerations are a + (r v_c, -r u_c, 0).  Wind adds what changes against still air.

    Raises
    ------
    ValueError : if the definition is not a 3-DOF one.
    """
    if definition.force_scale is None:
        raise ValueError(f"{definition.name} has no environment variant")
    u, v, r, _, _, psi = definition.states[:6]
    inputs = symbols(INPUTS)
    known = {symbol.name for symbol in definition.parameters}
    constants = [symbol for symbol in symbols(CONSTANTS) if symbol.name not in known]
    cosine, sine, uc, vc, ur, vr = symbols("env_cos env_sin env_uc env_vc env_ur env_vr")
    relative = {u: ur, v: vr}
    helpers = {
        cosine: sp.cos(psi),
        sine: sp.sin(psi),
        uc: inputs[0] * cosine + inputs[1] * sine,
        vc: -inputs[0] * sine + inputs[1] * cosine,
        ur: u - uc,
        vr: v - vc,
        **{name: expression.xreplace(relative) for name, expression in definition.helpers.items()},
    }
    wind_helpers, windage = _wind(u, v, cosine, sine, inputs[2], inputs[3]) if wind else ({}, [sp.S.Zero] * 3)
    convective = [r * vc, -r * uc, sp.S.Zero]
    forces = [
        force.xreplace(relative)
        + scale * (windage[row] + inputs[4 + row])
        + sum(definition.mass[row, column] * convective[column] for column in range(3))
        for row, (force, scale) in enumerate(zip(definition.forces, definition.force_scale, strict=True))
    ]
    return replace(
        definition,
        name=definition.name + ENVIRONMENT,
        inputs=[*definition.inputs, *inputs],
        constants=[*definition.constants, *constants],
        helpers={**helpers, **wind_helpers},
        forces=forces,
    )


def with_push(definition: Definition) -> Definition:
    """A yaw acceleration from outside, in the units of the highest derivative of a response model."""
    (push,) = symbols("push")
    return replace(
        definition,
        name=definition.name + PUSHED,
        inputs=[*definition.inputs, push],
        forces=[definition.forces[0] + push, *definition.forces[1:]],
        linear=False,
    )


def _wind(u, v, cosine, sine, north, east):
    """Wind force and moment on the hull, minus that of its own motion through still air.

    gamma = -atan2(v_rel, u_rel) of the hull's velocity through the air, q = rho_air V^2 / 2,
    D = 1 - delta/2 (1 - cx A_F/(cy A_L)) sin^2(2 gamma):  X = -cx cos(gamma) q A_F/D,
    Y = cy sin(gamma) q A_L/D,  N = (cn sin(2 gamma) - kn (|gamma| - pi/2) cy sin(gamma)/D) q A_L L.
    Blendermann 1994 has cn = 0, kn = .18; a plain sinusoidal fit has delta = kn = 0.
    """
    ua, va = symbols("env_ua env_va")
    helpers = {
        ua: u - (north * cosine + east * sine),
        va: v - (-north * sine + east * cosine),
    }
    moving, through = _windage("g", ua, va)
    own, still = _windage("o", u, v)
    return {**helpers, **moving, **own}, [a - b for a, b in zip(through, still, strict=True)]


def _windage(tag, ua, va):
    rho_air, front, side, cx, cy, cn, kn, delta, length = symbols(
        "rho_air A_F A_L wind_cx wind_cy wind_cn wind_kn wind_delta wind_L"
    )
    square, gamma, twice, shape = symbols(" ".join(f"env_{tag}_{name}" for name in ("square", "gamma", "s2", "D")))
    speed = sp.Symbol(f"env_{tag}_V", real=True)
    helpers = {
        square: ua**2 + va**2 + sp.Float(1e-12),
        speed: sp.sqrt(square),
        gamma: atan2v(-va, ua),
        twice: -2 * ua * va / square,
        shape: 1 - delta / 2 * (1 - cx * front / (cy * side)) * twice**2,
    }
    q = rho_air / 2
    surge = -cx * ua * speed * q * front / shape
    sway = -cy * va * speed * q * side / shape
    yaw = cn * twice * square * q * side * length - kn * (absv(gamma) - sp.pi.evalf(20) / 2) * sway * length
    return helpers, [surge, sway, yaw]
