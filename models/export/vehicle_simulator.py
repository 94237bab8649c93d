"""A vehicle of PythonVehicleSimulator (Fossen): one Python file that needs numpy and `math` alone."""

from __future__ import annotations

from ..errors import BadInput
from ..model import Model
from .equations import Python, values_of
from .texts import template

MOTION = {"u": "nu[0]", "v": "nu[1]", "r": "nu[5]", "x": "eta[0]", "y": "eta[1]", "psi": "eta[5]"}
"""State -> its place in the vectors of the simulator."""
INPUTS = ("delta", "n", "speed")


def vehicle_simulator(model: Model) -> dict[str, str]:
    """File name -> text of the vehicle.

    Raises
    ------
    BadInput : the model has inputs that the simulator does not give (wind, thrust).
    """
    others = [name for name in model.inputs if name not in INPUTS]
    if others:
        raise BadInput(f"{model.id} is driven by {', '.join(others)}, which the simulator does not give")
    values = values_of(model, Python())
    speed = values["start"].get("u", model.speed_m_s)
    text = template("vehicle_simulator.py").render(
        **values,
        length=float(model.particulars.get("L", 1.0)),
        speed=float(speed) if speed == speed else 1.0,
        inner={name: 0.0 for name in model.states if name not in MOTION},
        places={name: MOTION[name] for name in model.states if name in MOTION},
    )
    return {f"{values['name']}.py": text}
