"""Response models of craft whose steering moment depends on what makes it: thrusters, a rudder in the flow, in a race.

The moment of a rudder in the flow goes with U |U|, U being the speed ahead (negative astern), and the hull's damping
with |U|: with the ship's length L, r_dot = -|U| r / (T' L) + (U |U| / L^2) (K'/T') delta, T' = T U/L and K' = K L/U
(Nomoto 1960).  Astern the flow meets a rudder from the other side, so that its moment changes sign; damping takes
energy from the motion either way.  Behind a propeller the slipstream adds to the rudder's inflow what goes with the
square of the revolutions n, and does so at rest as well.  A thruster's moment does not know the speed, the damping of
the hull does.

Inputs are the rudder angle or the steering command, the speed through the water [m/s, negative astern] and the
revolutions [1/s], as they were measured: the speed is no state.  No length is needed: distances are in m.
"""

from __future__ import annotations

import sympy as sp

from ..definition import Definition, symbols
from ..primitives import absv

SOURCE = "Nomoto 1960, K' and T'; slipstream as in Yasukawa & Yoshimura 2015, eq 18, for small changes of the inflow"


def thruster() -> Definition:
    """r_dot = (a + a1 |U|) r + b delta + c U^2: the moment of thrusters, and of a hull that is not symmetric."""
    r, delta, speed = symbols("r delta speed")
    a, a1, b, c = coefficients = symbols("a a1 b c")
    return _law(
        "thruster-in-flow",
        "thrusters that turn a hull in the flow",
        coefficients,
        (a + a1 * absv(speed)) * r + b * delta + c * speed**2,
        {"a": "1/s", "a1": "1/m", "b": "1/s2", "c": "1/m2"},
        [speed],
    )


def in_flow() -> Definition:
    """r_dot = a1 |U| r + b2 U |U| delta: distance constant T' L = -1/a1, gain of curvature K'/L = -b2/a1."""
    r, delta, speed = symbols("r delta speed")
    a1, b2 = coefficients = symbols("a1 b2")
    return _law(
        "rudder-in-flow",
        "rudder in the flow (K', T')",
        coefficients,
        a1 * absv(speed) * r + b2 * speed * absv(speed) * delta,
        {"distance_constant": "m", "curvature_gain": "1/m"},
        [speed],
        {"distance_constant": -1 / a1, "curvature_gain": -b2 / a1},
        lambda t, k: {"a1": -1 / t, "b2": k / t},
    )


def in_race() -> Definition:
    """r_dot = a1 |U| r + (b2 U |U| + bn n^2) delta; a propeller that backs blows no race onto the rudder."""
    r, delta, turns, speed = symbols("r delta n speed")
    a1, b2, bn = coefficients = symbols("a1 b2 bn")
    ahead = (turns + absv(turns)) / 2
    return _law(
        "rudder-in-race",
        "rudder in a propeller's race",
        coefficients,
        a1 * absv(speed) * r + (b2 * speed * absv(speed) + bn * ahead**2) * delta,
        {"a1": "1/m", "b2": "1/m2", "bn": "1"},
        [turns, speed],
    )


def in_steady_race() -> Definition:
    """r_dot = a1 |U| r + (b + b2 U |U|) delta: revolutions that are not known and do not change much."""
    r, delta, speed = symbols("r delta speed")
    a1, b, b2 = coefficients = symbols("a1 b b2")
    return _law(
        "rudder-in-steady-race",
        "rudder in the race of a propeller at constant revolutions",
        coefficients,
        a1 * absv(speed) * r + (b + b2 * speed * absv(speed)) * delta,
        {"a1": "1/m", "b": "1/s2", "b2": "1/m2"},
        [speed],
    )


def twin_thrusters() -> Definition:
    """r_dot = (a + a1 |U|) r + b (P - S) + bs (P + S) + c U^2, P and S the thrusts of port and starboard: the moment
    of a propeller is b + bs or b - bs times its thrust, so that bs tells how unequal the two are."""
    r, delta, total, speed = symbols("r delta thrust_sum speed")
    a, a1, b, bs, c = coefficients = symbols("a a1 b bs c")
    return _law(
        "twin-thrusters",
        "two thrusters that turn a hull in the flow",
        coefficients,
        (a + a1 * absv(speed)) * r + b * delta + bs * total + c * speed**2,
        {"a": "1/s", "a1": "1/m", "b": "1/s2", "bs": "1/s2", "c": "1/m2"},
        [total, speed],
    )


def azimuth() -> Definition:
    """r_dot = (a + a1 |U|) r + bn n |n| sin(delta): a thruster of revolutions n that is turned by the angle delta."""
    r, delta, turns, speed = symbols("r delta n speed")
    a, a1, bn = coefficients = symbols("a a1 bn")
    return _law(
        "azimuth-thruster",
        "azimuth thruster",
        coefficients,
        (a + a1 * absv(speed)) * r + bn * turns * absv(turns) * sp.sin(delta),
        {"a": "1/s", "a1": "1/m", "bn": "1"},
        [turns, speed],
    )


def _law(name, title, coefficients, force, units, inputs, public=None, inverse=None) -> Definition:
    """A first-order response model; inverse takes the published parameters in their order."""
    r, psi, delta = symbols("r psi delta")
    back = None if inverse is None else inverse(*symbols(" ".join(units)))
    return Definition(
        name=name,
        title=title,
        states=[r, psi],
        inputs=[delta, *inputs],
        coefficients=coefficients,
        constants=[],
        mass=sp.eye(1),
        forces=[force],
        kinematics=[r],
        public=public,
        inverse=back,
        units=units,
        source=SOURCE,
    )


DEFINITIONS = {
    "thruster-in-flow": thruster,
    "rudder-in-flow": in_flow,
    "rudder-in-race": in_race,
    "rudder-in-steady-race": in_steady_race,
    "twin-thrusters": twin_thrusters,
    "azimuth-thruster": azimuth,
}
