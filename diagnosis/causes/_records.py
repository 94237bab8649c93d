"""Faults of whole records: columns read wrongly, looked for before all else and put right."""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from .base import Cause, NotTestable

if TYPE_CHECKING:
    from ...datasets.record import Record
    from ...estimation.filters.innovations.estimator import Estimator
    from ...models.model import Model
    from ..state import Variant


@dataclass(frozen=True)
class RecordFault:
    """A fault that was found: its cause, what a finding says of it, how clearly it shows (in sd, squared), and the
    instruments of a model that has it."""

    cause: RecordCause
    details: Mapping[str, Any]
    evidence: str
    statistic: float
    instruments: Mapping[str, float]


class RecordCause(Cause):
    """Base class of causes that make whole columns mean something else.

    rank : causes of lower rank are looked for first.
    """

    where = "record"
    unit = "1"
    rank = 0

    def variants(self, est: Estimator) -> Sequence[Variant]:
        raise NotTestable("looked for in the records themselves, before all else")

    @abstractmethod
    def find(self, records: Sequence[Record], model: Model) -> tuple[list[RecordFault], list[Record]]:
        """Faults of this kind, and the records with them put right."""
