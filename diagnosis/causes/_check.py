"""Faults of sensors and files that show without any model: `check` looks for them, a diagnosis does not test them."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

from .base import Cause, NotTestable

if TYPE_CHECKING:
    from ...datasets.record import Record
    from ...estimation.filters.innovations.estimator import Estimator
    from ..kinematics.fault import Fault
    from ..state import Variant


class CheckCause(Cause):
    """Base class of causes that the channels show of each other or by themselves, without a hull model."""

    where = "record"
    unit = "1"

    def variants(self, est: Estimator) -> Sequence[Variant]:
        raise NotTestable("looked for in the records themselves, without a model")

    def find(self, record: Record) -> list[Fault]:
        """Faults of this kind in one record; empty for causes that only the sensors' comparison shows."""
        return []
