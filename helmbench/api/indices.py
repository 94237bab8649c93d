"""A model of a ship of which only manoeuvring indices are known."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

from ..estimation.indices.result import ModelFromIndices
from ..models.argument_types import typed

if TYPE_CHECKING:
    from .arguments import Path


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
