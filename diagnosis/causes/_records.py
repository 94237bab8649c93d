"""Causes that stages of their own look for: faults of whole records before the bank, the base model after it."""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from ._stage import StageCause

if TYPE_CHECKING:
    from ...datasets.record import Record


@dataclass(frozen=True)
class RecordFault:
    """A fault that was found: its cause, what a finding says of it, how clearly it shows (in sd, squared), and the
    instruments of a model that has it."""

    cause: RecordCause
    details: Mapping[str, Any]
    evidence: str
    statistic: float
    instruments: Mapping[str, float]


class RecordCause(StageCause):
    """Base class of causes that make whole columns mean something else.

    rank : causes of lower rank are looked for first.
    """

    where = "record"
    stage = "looked for in the records themselves, before all else"
    rank = 0

    @abstractmethod
    def find(self, records: Sequence[Record], starboard: float) -> tuple[list[RecordFault], list[Record]]:
        """Faults of this kind, and the records with them put right.

        starboard : 1 where a positive rudder is to turn the ship to starboard, -1 to port.
        """
