"""Which model structures can be tried on records."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

from ...models import kernels
from ...models.model import resolve
from ...models.vessel import vessel_files

if TYPE_CHECKING:
    from ...datasets.record import Record
    from ...models.model import Model


def families_for(records: Sequence[Record]) -> list[Model]:
    """Families that need no constants of a ship, and the structures of vessels that the records name, blank.

    A 3-DOF model has lengths and masses in it: without a vessel there is none to try.
    """
    free = [resolve(name) for name, facts in kernels.catalogue().items() if not facts["constants"]]
    vessels = dict.fromkeys(record.meta.vessel for record in records if record.meta.vessel in vessel_files())
    named = [resolve(vessel) for vessel in vessels if vessel is not None]
    return [*free, *(model.blanked() for model in named if model.family not in {one.family for one in free})]
