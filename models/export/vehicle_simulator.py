"""A vehicle of PythonVehicleSimulator (Fossen): one Python file that needs numpy and `math` alone."""

from __future__ import annotations

from ..errors import BadInput
from ..model import Model
from ..simulate import initial_state
from .equations import Python, definition, gear, heading, identifier, numbers, statements
from .texts import inert

MOTION = {"u": "nu[0]", "v": "nu[1]", "r": "nu[5]", "x": "eta[0]", "y": "eta[1]", "psi": "eta[5]"}
"""State -> its place in the vectors of the simulator."""
INPUTS = ("delta", "n", "speed")
TEMPLATE = '''"""{heading}"""

import math

import numpy as np

NUMBERS = {numbers}
RUDDER = {gear}


def derivative(state, given, p=NUMBERS):
    """Time derivatives of the states {states} under the inputs {inputs}."""
{equations}


class {name}:
    """A vehicle as the simulator's main loop takes it: dynamics, stepInput."""

    def __init__(self, n_rps={n0}, max_step_s={step}):
        self.name, self.controls, self.dimU = {id!r}, ["Rudder angle (deg)"], 1
        self.controlDescription = "Step input for delta_r"
        self.L, self.n, self.max_step_s = {length}, n_rps, max_step_s
        self.nu = np.array([{speed}, 0, 0, 0, 0, 0], float)
        self.u_actual = np.array([0.0])
        self.inner = {inner}

    def dynamics(self, eta, nu, u_actual, u_control, sampleTime):
        """nu[k+1], u_actual[k+1] by fourth-order Runge-Kutta steps; the rudder follows its limits."""
        nu = np.array(nu, float)
        delta = self.rudder(u_actual[0], u_control[0], sampleTime)
        known = dict(self.inner, **{{{taken}}})
        given = {{"delta": u_actual[0], "n": self.n, "speed": math.copysign(math.hypot(nu[0], nu[1]), nu[0])}}
        known = self.advance(known, given, sampleTime)
        self.inner = {{name: known[name] for name in self.inner}}
{put}
        return nu, np.array([delta])

    def advance(self, known, given, duration):
        """The states after some time, the inputs being held."""
        count = max(1, math.ceil(duration / self.max_step_s - 1e-9))
        h = duration / count
        for _ in range(count):
            k1 = derivative(known, given)
            k2 = derivative({{s: x + 0.5 * h * k1[s] for s, x in known.items()}}, given)
            k3 = derivative({{s: x + 0.5 * h * k2[s] for s, x in known.items()}}, given)
            k4 = derivative({{s: x + h * k3[s] for s, x in known.items()}}, given)
            known = {{s: x + h / 6.0 * (k1[s] + 2.0 * k2[s] + 2.0 * k3[s] + k4[s]) for s, x in known.items()}}
        return known

    def rudder(self, delta, command, duration):
        """The rudder angle after some time."""
        target = min(max(command, -RUDDER["max_rad"]), RUDDER["max_rad"])
        change = target - delta
        if RUDDER["lag_s"] > 0.0:
            change *= 1.0 - math.exp(-duration / RUDDER["lag_s"])
        most = RUDDER["rate_rad_s"] * duration
        return delta + min(max(change, -most), most)

    def stepInput(self, t):
        """10 degrees of rudder for 50 s."""
        return np.array([math.radians(10.0) if t <= 50.0 else 0.0])
'''


def vehicle_simulator(model: Model) -> dict[str, str]:
    """File name -> text of the vehicle.

    Raises
    ------
    BadInput : the model has inputs that the simulator does not give (wind, thrust).
    """
    own, name = definition(model), identifier(model)
    others = [symbol.name for symbol in own.inputs if symbol.name not in INPUTS]
    if others:
        raise BadInput(f"{model.id} is driven by {', '.join(others)}, which the simulator does not give")
    start = dict(zip(model.states, initial_state(model).tolist(), strict=True))
    lines = [f'{s.name} = state["{s.name}"]' for s in own.states]
    lines += [f'{s.name} = given["{s.name}"]' for s in own.inputs]
    lines += [f'{s.name} = p["{s.name}"]' for s in own.parameters]
    lines += [f"{left} = {right}" for left, right in statements(own, Python())]
    lines += ["return {" + ", ".join(f'"{s.name}": d_{s.name}' for s in own.states) + "}"]
    moving = [s.name for s in own.states if s.name in MOTION]
    speed = start.get("u", model.speed_m_s)
    text = TEMPLATE.format(
        heading="\n".join(heading(model)),
        numbers=repr(numbers(model)),
        gear=repr(gear(model)).replace("inf", "math.inf"),
        states=", ".join(s.name for s in own.states),
        inputs=", ".join(s.name for s in own.inputs),
        equations="\n".join(f"    {line}" for line in lines),
        name=name,
        id=inert(model.id),
        n0=repr(model.n0_rps),
        step=repr(float(model.max_step_s)),
        length=repr(float(model.particulars.get("L", 1.0))),
        speed=repr(float(speed)) if speed == speed else "1.0",
        inner=repr({s.name: 0.0 for s in own.states if s.name not in MOTION}),
        taken=", ".join(f'"{s}": {MOTION[s]}' for s in moving),
        put="\n".join(f'        {MOTION[s]} = known["{s}"]' for s in moving if MOTION[s].startswith("nu")),
    )
    return {f"{name}.py": text}
