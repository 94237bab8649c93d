"""Which records a command takes: refused where their numbers cannot be what they say, else with their doubts."""

from __future__ import annotations

import warnings
from collections.abc import Sequence
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from ..datasets.record import Record
    from ..models.model import Model

FILE_FAULTS = ("frozen_samples", "splice")
"""Faults of a file, as `check` finds them, that every command tells: a channel stands still, or jumps."""


def admit(records: Sequence[Record], model: Model) -> tuple[str, ...]:
    """What is doubtful about records of the model's ship, one sentence each.

    Raises
    ------
    BadInput : records hold a run twice, their numbers are in another unit than their columns say, or they are of
        another ship or scale than the model.
    """
    from ..datasets.plausibility import check_plausible

    return (
        *check_plausible(records, model),
        *(told for record in records for told in _file_doubts(record)),
    )


def warn_of(doubts: Sequence[str]) -> None:
    """Issue a PlausibilityWarning for every doubt."""
    from ..datasets.plausibility import PlausibilityWarning

    for doubt in doubts:
        warnings.warn(doubt, PlausibilityWarning, stacklevel=3)


def _file_doubts(record: Record) -> list[str]:
    from ..checks.check import file_faults

    found, _, _, _ = file_faults(record, FILE_FAULTS)
    return [f"{record.name}: {f.evidence}" for f in found if f.material]
