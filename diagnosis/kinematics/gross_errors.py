"""Faults of whole records, found and corrected before everything else.

They need no dynamic model: headings are compared with integrated yaw rates, displacements with integrated velocities,
and the yaw acceleration with the rudder.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

from ...checks.registry import column_checks

if TYPE_CHECKING:
    from ...checks.columns._base import ColumnFault
    from ...datasets.record import Record
    from ...models.model import Model


def corrected_for(records: Sequence[Record], model: Model) -> tuple[list[Record], list[ColumnFault]]:
    """Records with gross faults corrected, and what they were."""
    found: list[ColumnFault] = []
    current = list(records)
    for check in column_checks():
        faults, current = check.find(current, model.starboard)
        found += faults
    return current, found
