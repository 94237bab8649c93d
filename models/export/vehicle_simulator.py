"""A vehicle of PythonVehicleSimulator (Fossen): one Python file that needs numpy and `math` alone."""

from __future__ import annotations

from ..errors import BadInput
from ..model import Model
from ..simulate import initial_state
from .equations import Python, definition, gear, heading, identifier, numbers, statements
from .texts import filled, inert

MOTION = {"u": "nu[0]", "v": "nu[1]", "r": "nu[5]", "x": "eta[0]", "y": "eta[1]", "psi": "eta[5]"}
"""State -> its place in the vectors of the simulator."""
INPUTS = ("delta", "n", "speed")


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
    text = filled(
        "vehicle_simulator.txt",
        HEADING="\n".join(heading(model)),
        NUMBERS=repr(numbers(model)),
        GEAR=repr(gear(model)).replace("inf", "math.inf"),
        STATES=", ".join(s.name for s in own.states),
        INPUTS=", ".join(s.name for s in own.inputs),
        EQUATIONS="\n".join(f"    {line}" for line in lines),
        NAME=name,
        ID=repr(inert(model.id)),
        N=repr(model.n0_rps),
        STEP=repr(float(model.max_step_s)),
        LENGTH=repr(float(model.particulars.get("L", 1.0))),
        SPEED=repr(float(speed)) if speed == speed else "1.0",
        INNER=repr({s.name: 0.0 for s in own.states if s.name not in MOTION}),
        TAKEN=", ".join(f'"{s}": {MOTION[s]}' for s in moving),
        PUT="\n".join(f'        {MOTION[s]} = known["{s}"]' for s in moving if MOTION[s].startswith("nu")),
    )
    return {f"{name}.py": text}
