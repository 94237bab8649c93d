"""Models as files of other programs, and models of published tables and of manoeuvring indices."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path as FilePath
from typing import TYPE_CHECKING, Any

from ..estimation.indices.result import ModelFromIndices
from ..models.argument_types import typed
from ..models.files import content_writer, refuse_existing, write_together
from .arguments import as_model

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

    found = exported(as_model(model), to)
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


# ---- A model of a ship of which only manoeuvring indices are known.


@typed
def model_from_indices(source: Mapping[str, Any] | Path) -> ModelFromIndices:
    """A model from the indices of a manoeuvring booklet, a wheelhouse poster or a sea trial.

    The family is `turning-response`: a first-order yaw response with cubic damping, drift and speed loss.  Indices of
    turning circles and zigzags are fitted by bounded least squares, weighted by their accuracies, with a prior on each
    parameter; intervals are those of the linearised posterior, wider where the model misses the indices.  Indices of
    IMO MSC.137(76) that are not given are predicted.  The page From indices to a model (docs/how-to) has the keys, the
    accuracies that are assumed, and errors on published and measured ships.

    Parameters
    ----------
    source : YAML or JSON file, or a mapping of the same content: name, length_m, speed_m_s or speed_kn (of the
        approach), rudder_rate_deg_s, rudder_max_deg, and indices, a list with manoeuvre, values such as advance_m and
        first_overshoot_deg, and accuracy.

    Raises
    ------
    BadInput : the file cannot be read, has an unknown key, numbers that no ship has, or too few indices.
    FitFailed : no model of the family performs the manoeuvres.
    """
    from ..estimation.indices.fit import fit
    from ..estimation.indices.given import read_indices

    return fit(read_indices(source))
