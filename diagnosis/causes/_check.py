"""Faults of sensors and files that show without any model: `check` looks for them, a diagnosis does not test them."""

from __future__ import annotations

from typing import TYPE_CHECKING

from ._stage import StageCause

if TYPE_CHECKING:
    from ...datasets.record import Record
    from ..kinematics.fault import Fault


class CheckCause(StageCause):
    """Base class of causes that the channels show of each other or by themselves, without a hull model."""

    where = "record"
    stage = "looked for in the records themselves, without a model"

    def find(self, record: Record) -> list[Fault]:
        """Faults of this kind in one record; empty for causes that only the sensors' comparison shows."""
        return []
