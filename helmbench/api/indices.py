"""A model of a ship of which only manoeuvring indices are known."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import asdict
from typing import TYPE_CHECKING, Any

from ..estimation.indices import result
from ..models.argument_types import typed
from ..models.extras import extras_told
from .results import Told

if TYPE_CHECKING:
    import pandas as pd

    from .arguments import Path


class ModelFromIndices(result.ModelFromIndices, Told):
    """The outcome of `model_from_indices`: a model with intervals, and its indices beside those given.

    `model` is taken by `simulate`, `validate` and `diagnose` like any other; `parameters` have a value and a 95 %
    interval, None where the indices do not determine them; `indices` are those given, then others that the model
    predicts; `missed` those that it does not give; `excess` says by how much intervals are wider for that.
    """

    room = "indices.page"

    def statement(self) -> list[str]:
        """What the indices determine, what the model cannot give, and what the intervals hold for: sentences."""
        from ..reporting.indices.page import statement

        return statement(self)

    def to_json(self) -> dict[str, Any]:
        """Statement, parameters and indices as plain data."""
        return {
            "name": self.model.id,
            "family": self.model.family,
            "statement": self.statement(),
            "parameters": [asdict(row) for row in self.parameters],
            "indices": [asdict(row) | {"difference": row.difference} for row in self.indices],
            "excess": self.excess,
        }

    @extras_told()
    def to_dataframe(self) -> pd.DataFrame:
        """The parameters: a row each, with unit, value, low and high, which are nan where it is not determined."""
        import pandas as pd

        rows = [(row.unit, row.value, *(row.interval or (float("nan"),) * 2)) for row in self.parameters]
        index = pd.Index([row.name for row in self.parameters], name="parameter")
        return pd.DataFrame(rows, index=index, columns=pd.Index(["unit", "value", "low", "high"]))

    @extras_told()
    def indices_to_dataframe(self) -> pd.DataFrame:
        """The indices: a row each, in the unit of its key."""
        import pandas as pd

        return pd.DataFrame([asdict(row) | {"difference": row.difference} for row in self.indices])

    def save(self, path: Path) -> None:
        """Write the model as a model.json; BadInput where the file cannot be written."""
        from ..models.model import model_to_json

        model_to_json(self.model, path)

    def __repr__(self) -> str:
        known = len(self.parameters) - len(self.undetermined)
        return f"<ModelFromIndices {self.model.id!r}: {known} of {len(self.parameters)} parameters determined>"


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

    return ModelFromIndices.of(fit(read_indices(source)))
