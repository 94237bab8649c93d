"""What a fit to manoeuvring indices gives."""

from __future__ import annotations

import math
from dataclasses import asdict, dataclass
from typing import TYPE_CHECKING, Any, ClassVar

from ...models.extras import extras_told
from ...models.model import Model, model_to_json
from ...models.result import FilePath, Result, above

if TYPE_CHECKING:
    import pandas as pd

MISSED = 2.0
"""Standard deviations beyond which the model does not give an index."""


@dataclass(frozen=True)
class ParameterRow:
    """A parameter: value and 95 % interval, None where the indices do not determine it."""

    name: str
    unit: str
    value: float
    interval: tuple[float, float] | None


@dataclass(frozen=True)
class IndexRow:
    """An index in the unit of its key: given with its standard deviation (None: not given), and of the model with 95 %
    interval (None: not reached)."""

    manoeuvre: str
    key: str
    given: float | None
    accuracy: float | None
    predicted: float | None
    low: float | None
    high: float | None

    @property
    def difference(self) -> float | None:
        """Predicted less given, in the unit of the key."""
        return None if self.given is None or self.predicted is None else self.predicted - self.given

    @property
    def misfit(self) -> float:
        """The difference in standard deviations of the index; nan where it is not given."""
        return math.nan if self.difference is None or self.accuracy is None else self.difference / self.accuracy


@dataclass(frozen=True, repr=False)
class ModelFromIndices(Result):
    """The outcome of `model_from_indices`: a model with intervals, and its indices beside those given.

    `simulate`, `validate` and `diagnose` take the model like any other.

    model : of the family turning-response;  parameters : its parameters, and K' and T' where the indices say that the
    ship is stable on a straight course;
    indices : those given, then those of IMO MSC.137(76) that were not;  excess : factor of the accuracies by which the
    model misses the indices, at least 1: intervals hold it.
    """

    model: Model
    parameters: tuple[ParameterRow, ...]
    indices: tuple[IndexRow, ...]
    excess: float
    room: ClassVar[str] = "indices"

    @property
    def undetermined(self) -> tuple[str, ...]:
        """Parameters that the indices do not determine: the model has usual values for them."""
        return tuple(row.name for row in self.parameters if row.interval is None)

    @property
    def missed(self) -> tuple[IndexRow, ...]:
        """Given indices that the model misses by more than two standard deviations."""
        return tuple(row for row in self.indices if abs(row.misfit) > MISSED)

    def statement(self) -> list[str]:
        """What the indices determine, what the model cannot give, and what the intervals hold for: sentences."""
        return above("reporting.indices").statement(self)

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

    def save(self, path: FilePath) -> None:
        """Write the model as a model.json; BadInput where the file cannot be written."""
        model_to_json(self.model, path)

    def __repr__(self) -> str:
        known = len(self.parameters) - len(self.undetermined)
        return f"<ModelFromIndices {self.model.id!r}: {known} of {len(self.parameters)} parameters determined>"
