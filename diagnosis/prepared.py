"""Records as one stage of a diagnosis passes them to the next."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from ..checks.columns._base import ColumnFault
    from ..datasets.record import Record
    from .causes.base import Cause
    from .kinematics.tracks import Tracks


@dataclass(frozen=True)
class Prepared:
    """Records in the model's rudder sign with what was corrected: gross faults, and sensors by the tracks.

    decided : causes that the sensors' channels have decided on without a model.
    """

    train: list[Record]
    held_out: list[Record]
    faults: list[ColumnFault]
    tracks: Tracks
    decided: frozenset[Cause] = frozenset()

    @property
    def instruments(self) -> dict[str, float]:
        """What was corrected, as instruments of a model."""
        faults = {name: value for fault in self.faults for name, value in fault.instruments.items()}
        return faults | dict(self.tracks.instruments)
