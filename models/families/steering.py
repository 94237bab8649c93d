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

from collections.abc import Mapping
from functools import partial
from typing import NamedTuple

from ..definition import Definition, written

SOURCE = "Nomoto 1960, K' and T'; slipstream as in Yasukawa & Yoshimura 2015, eq 18, for small changes of the inflow"


class SteeringLaw(NamedTuple):
    """What makes the yaw rate of a craft: r_dot = `rate`, of the coefficients of `units` (coefficient -> unit), the
    yaw rate r, delta and further inputs.

    public, inverse : as `Definition`; units are those of the published parameters then.
    """

    title: str
    rate: str
    inputs: str
    units: Mapping[str, str]
    coefficients: str = ""
    public: Mapping[str, str] | None = None
    inverse: Mapping[str, str] | None = None

    def definition(self, name: str) -> Definition:
        """The law as a family of that name."""
        return written(
            name=name,
            title=self.title,
            states="r psi",
            inputs=f"delta {self.inputs}",
            coefficients=self.coefficients or " ".join(self.units),
            forces=[self.rate],
            kinematics=["r"],
            public=self.public,
            inverse=self.inverse,
            units=self.units,
            source=SOURCE,
        )


LAWS = {
    # the moment of thrusters, and of a hull that is not symmetric
    "thruster-in-flow": SteeringLaw(
        "thrusters that turn a hull in the flow",
        "(a + a1*absv(speed))*r + b*delta + c*speed**2",
        "speed",
        {"a": "1/s", "a1": "1/m", "b": "1/s2", "c": "1/m2"},
    ),
    # distance constant T' L, gain of curvature K'/L
    "rudder-in-flow": SteeringLaw(
        "rudder in the flow (K', T')",
        "a1*absv(speed)*r + b2*speed*absv(speed)*delta",
        "speed",
        {"distance_constant": "m", "curvature_gain": "1/m"},
        "a1 b2",
        {"distance_constant": "-1/a1", "curvature_gain": "-b2/a1"},
        {"a1": "-1/distance_constant", "b2": "curvature_gain/distance_constant"},
    ),
    # a propeller that backs blows no race onto the rudder
    "rudder-in-race": SteeringLaw(
        "rudder in a propeller's race",
        "a1*absv(speed)*r + (b2*speed*absv(speed) + bn*((n + absv(n))/2)**2)*delta",
        "n speed",
        {"a1": "1/m", "b2": "1/m2", "bn": "1"},
    ),
    # revolutions that are not known and do not change much
    "rudder-in-steady-race": SteeringLaw(
        "rudder in the race of a propeller at constant revolutions",
        "a1*absv(speed)*r + (b + b2*speed*absv(speed))*delta",
        "speed",
        {"a1": "1/m", "b": "1/s2", "b2": "1/m2"},
    ),
    # delta = P - S and thrust_sum = P + S of the thrusts of port and starboard: the moment of a propeller is b + bs or
    # b - bs times its thrust, so that bs tells how unequal the two are
    "twin-thrusters": SteeringLaw(
        "two thrusters that turn a hull in the flow",
        "(a + a1*absv(speed))*r + b*delta + bs*thrust_sum + c*speed**2",
        "thrust_sum speed",
        {"a": "1/s", "a1": "1/m", "b": "1/s2", "bs": "1/s2", "c": "1/m2"},
    ),
    # a thruster of revolutions n that is turned by the angle delta
    "azimuth-thruster": SteeringLaw(
        "azimuth thruster",
        "(a + a1*absv(speed))*r + bn*n*absv(n)*sin(delta)",
        "n speed",
        {"a": "1/s", "a1": "1/m", "bn": "1"},
    ),
}
DEFINITIONS = {name: partial(law.definition, name) for name, law in LAWS.items()}
