"""Faults of whole records, found and put right before everything else.

They need no dynamic model: headings are compared with integrated yaw rates, displacements with integrated velocities,
and the yaw acceleration with the rudder.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

from ..causes.registry import record_causes

if TYPE_CHECKING:
    from ...datasets.record import Record
    from ...models.model import Model
    from ..causes._records import RecordFault


def put_right(records: Sequence[Record], model: Model) -> tuple[list[Record], list[RecordFault]]:
    """Records with gross faults corrected, and what they were."""
    found: list[RecordFault] = []
    current = list(records)
    for cause in record_causes():
        faults, current = cause.find(current, model.starboard)
        found += faults
    return current, found
