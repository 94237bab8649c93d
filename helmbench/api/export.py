"""Models as files of other programs."""

from __future__ import annotations

from pathlib import Path as FilePath
from typing import TYPE_CHECKING

from ..models.argument_types import typed
from .documents import refuse_existing, text_writer, write_together

if TYPE_CHECKING:
    from ..models.model import Model
    from .identification import Path


@typed
def export_model(model: Model | Path, to: str, output: Path, *, force: bool = False) -> tuple[FilePath, ...]:
    """Write a model as files that another program reads.

    Parameters
    ----------
    model : a model, or the vessel id or model.json of one, with its coefficients.
    to : 'simulink' (a MATLAB struct, its derivative as a function, idgrey and idnlgrey scripts), 'vehicle-simulator'
        (a vehicle of PythonVehicleSimulator), 'mmgdynamics' (its parameter table) or 'gazebo' (inertia, added mass and
        damping, also for VRX).
    output : the folder, which is made where it is missing.
    force : replace files that exist.

    Returns
    -------
    The paths of the files.

    Raises
    ------
    BadInput : the format is unknown or cannot hold the model, a file exists, or the folder cannot be written to.
    """
    from ..models.export.formats import exported
    from ..models.model import Model, resolve

    found = exported(model if isinstance(model, Model) else resolve(model), to)
    folder = FilePath(output)
    if not force:
        refuse_existing(folder / name for name in found)
    return write_together(folder, {name: text_writer(text) for name, text in found.items()})
