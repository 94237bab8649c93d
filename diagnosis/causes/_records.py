"""Causes that stages of their own look for: faults of whole records before the bank, the base model after it."""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, ClassVar

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


class StageCause(Cause):
    """Base class of causes that a stage of its own looks for; the bank does not hold them.

    stage : where it is looked for, as a reason why the bank does not test it.
    """

    unit = "1"
    stage: ClassVar[str]

    def variants(self, est: Estimator) -> Sequence[Variant]:
        raise NotTestable(self.stage)


class RecordCause(StageCause):
    """Base class of causes that make whole columns mean something else.

    rank : causes of lower rank are looked for first.
    """

    where = "record"
    stage = "looked for in the records themselves, before all else"
    rank = 0

    @abstractmethod
    def find(self, records: Sequence[Record], model: Model) -> tuple[list[RecordFault], list[Record]]:
        """Faults of this kind, and the records with them put right."""
