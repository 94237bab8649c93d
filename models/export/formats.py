"""Every format that a model is exported to."""

from __future__ import annotations

from collections.abc import Callable, Mapping

from ..errors import BadInput
from ..mmgdynamics import mmgdynamics
from ..model import Model
from ..suggestions import suggestion
from .fmu import fmu
from .gazebo import gazebo
from .simulink import simulink
from .vehicle_simulator import vehicle_simulator

FORMATS: Mapping[str, Callable[[Model], Mapping[str, str | bytes]]] = {
    "simulink": simulink,
    "vehicle-simulator": vehicle_simulator,
    "mmgdynamics": mmgdynamics,
    "gazebo": gazebo,
    "fmu": fmu,
}
"""Name -> function of a model that gives file names with their contents."""


def exported(model: Model, to: str) -> Mapping[str, str | bytes]:
    """File name -> content of a model in a format; BadInput where there is none such or it cannot hold the model."""
    if to not in FORMATS:
        raise BadInput(f"unknown format {to!r}", hint=suggestion(to, FORMATS) or f"known: {', '.join(FORMATS)}")
    return FORMATS[to](model)
