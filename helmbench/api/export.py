"""Models as files of other programs."""

from __future__ import annotations

from pathlib import Path as FilePath
from typing import TYPE_CHECKING

from ..models.argument_types import typed
from ..models.files import content_writer, refuse_existing, write_together

if TYPE_CHECKING:
    from ..models.model import Model
    from .arguments import Path


@typed
def export_model(model: Model | Path, to: str, output: Path, *, force: bool = False) -> tuple[FilePath, ...]:
    """Write a model as files that another program reads.

    Parameters
    ----------
    model : a model, or the vessel id or model.json of one, with its coefficients.
    to : 'simulink' (a MATLAB struct, its derivative as a function, idgrey and idnlgrey scripts), 'vehicle-simulator'
        (a vehicle of PythonVehicleSimulator), 'mmgdynamics' (its parameter table), 'gazebo' (inertia, added mass and
        damping, also for VRX) or 'fmu' (a functional mock-up unit for co-simulation, FMI 2.0, of C source; compiled
        where there is a C compiler, with a warning where there is none).
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
    return write_together(folder, {name: content_writer(content) for name, content in found.items()})


@typed
def read_parameters(
    table: Path, family: str, *, positive_rudder: str, speed_m_s: float | None = None, n0_rps: float | None = None
) -> Model:
    """A model from a published table of parameters.

    Parameters
    ----------
    table : a CSV file with the columns name, value and perhaps unit, or a YAML or JSON file of names with numbers; a
        scale such as 1e-5 stands in the heading of the values or in a unit.  Family 'mmg' takes a table of mmgdynamics.
    family : id of the equations, as `list_models` shows.
    positive_rudder : 'port' or 'starboard', the side to which a positive rudder angle turns the ship in the table.
    speed_m_s : speed of the straight course, m/s; without it U0 of the table, where the family has one.
    n0_rps : revolutions of the straight course, 1/s.

    Raises
    ------
    BadInput : a name is unknown, missing or there twice, a value is no number or one that no ship has, a unit is of
        another quantity, or the rudder turns the ship to the other side.

    Warns
    -----
    RuntimeWarning : a value that hardly any ship has, or keys of a table of mmgdynamics that were left out.
    """
    from ..models.parameter_table import model_of_table

    return model_of_table(FilePath(table), family, positive_rudder, speed_m_s, n0_rps)
