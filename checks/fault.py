"""Faults that need no model to be seen: of one record, and of whole columns."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

import numpy as np

from ..datasets.columns import POSITIONS, TURN, VELOCITIES
from ..datasets.geometry import over_ground
from .result import Size

if TYPE_CHECKING:
    from ..datasets.record import Record
    from .base import ColumnCheck


SENSED = (*TURN, *VELOCITIES, *POSITIONS)
"""Columns of sensors, which change in every sample: a rudder or a propeller may be held."""


@dataclass(frozen=True)
class Fault:
    """What is wrong, as a sentence with its figures.

    channels : columns that are concerned.  sizes : numbers of the fault with their intervals.  material : whether it
    would falsify what the record gives; else it is a remark.  blanks : samples (column, start, stop) that are
    no measurements.  factors : column -> what its values are to be multiplied by.
    steps : (column, start, step) that the values from a sample on are to be lowered by.
    turns : (start, angle) that surge and sway from a sample on are to be turned by, rad.
    corrects : the check itself returned the record corrected.  biases : a fit to the record as it is would be wrong by
    it (None: where it can be corrected).  standing : it cannot be corrected, and while it stands
    nothing that a model says of the hull can be trusted.
    """

    evidence: str
    channels: tuple[str, ...] = ()
    sizes: tuple[Size, ...] = ()
    material: bool = True
    blanks: tuple[tuple[str, int, int], ...] = ()
    factors: Mapping[str, float] = field(default_factory=dict)
    steps: tuple[tuple[str, int, float], ...] = ()
    turns: tuple[tuple[int, float], ...] = ()
    standing: bool = False
    corrects: bool = False
    biases: bool | None = None

    @property
    def corrected(self) -> bool:
        """Whether the record can be corrected for it."""
        return self.material and (self.corrects or bool(self.blanks or self.factors or self.steps))


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


def exact(parameter: str, value: float, unit: str) -> Size:
    """A size that is counted or read off, without an interval."""
    return Size(parameter, float(value), float(value), float(value), unit)


def cleaned(record: Record, faults: Sequence[Fault]) -> Record:
    """The record with blanked samples as gaps, and wrong factors and steps corrected, for faults that matter."""
    channels = {name: values.copy() for name, values in record.channels.items()}
    for fault in (f for f in faults if f.material):
        for name, factor in fault.factors.items():
            channels[name] = channels[name] * factor
        for name, start, step in fault.steps:
            channels[name][start:] -= step
        for start, angle in fault.turns:
            turned = over_ground(channels["surge_m_s"][start:], channels["sway_m_s"][start:], angle)
            channels["surge_m_s"][start:], channels["sway_m_s"][start:] = turned.real, turned.imag
        for name, start, stop in fault.blanks:
            channels[name][max(start, 0) : stop] = np.nan
    return record.with_channels(**channels)
