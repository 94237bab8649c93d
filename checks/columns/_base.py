"""Checks of what whole columns mean: what they have in common, and a fault that they find."""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, ClassVar

from ..base import Check
from ..result import Size

if TYPE_CHECKING:
    from ...datasets.record import Record


@dataclass(frozen=True)
class ColumnFault:
    """A fault that was found: its check, what a finding says of it, how clearly it shows (in sd, squared), the
    instruments of a model that has it, and its sizes in the record."""

    check: ColumnCheck
    details: Mapping[str, Any]
    evidence: str
    statistic: float
    instruments: Mapping[str, float]
    sizes: tuple[Size, ...] = ()


class ColumnCheck(Check):
    """Base class of checks that show that whole columns mean something else.

    rank : checks of lower rank are looked for first.  joint : whether the records of one side of a positive rudder are
    looked at together, and then each by itself; else each by itself.  columns : those that it concerns, where a fault
    does not say.
    """

    stage = "looked for in the records themselves, before all else"
    rank = 0
    joint = False
    columns: ClassVar[tuple[str, ...]] = ()
    named = True

    @abstractmethod
    def find(self, records: Sequence[Record], starboard: float) -> tuple[list[ColumnFault], list[Record]]:
        """Faults of this kind, and the records with them corrected.

        starboard : 1 where a positive rudder is to turn the ship to starboard, -1 to port.
        """
