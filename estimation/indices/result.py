"""What a fit to manoeuvring indices gives."""

from __future__ import annotations

import math
from dataclasses import dataclass

from ...models.model import Model

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
class ModelFromIndices:
    """A model from manoeuvring indices.

    model : of the family turning-response;  parameters : its parameters, and K' and T' where the indices say that the
    ship is stable on a straight course;
    indices : those given, then those of IMO MSC.137(76) that were not;  excess : factor of the accuracies by which the
    model misses the indices, at least 1: intervals hold it.
    """

    model: Model
    parameters: tuple[ParameterRow, ...]
    indices: tuple[IndexRow, ...]
    excess: float

    @property
    def undetermined(self) -> tuple[str, ...]:
        """Parameters that the indices do not determine: the model has usual values for them."""
        return tuple(row.name for row in self.parameters if row.interval is None)

    @property
    def missed(self) -> tuple[IndexRow, ...]:
        """Given indices that the model misses by more than two standard deviations."""
        return tuple(row for row in self.indices if abs(row.misfit) > MISSED)
