"""What a check is: one class whose body is a row of data, and all that is known of it without a hull model; and the
faults that it finds.

A check says what it looks for (its docstring: in words and as an equation), the unit of its sizes, and what would tell
it from its rivals.  `FileCheck` looks at one record, `ColumnCheck` at what whole columns mean, `SensorError` leaves
something between channels that must agree.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from inspect import cleandoc
from typing import TYPE_CHECKING, Any, ClassVar, NamedTuple

import numpy as np

from ..datasets.columns import POSITIONS, TURN, VELOCITIES
from ..datasets.geometry import over_ground
from .result import Size

if TYPE_CHECKING:
    from ..datasets.record import Record
    from .comparison.series import Log, Path, SensorEffect, Turn

SENSED = (*TURN, *VELOCITIES, *POSITIONS)
"""Columns of sensors, which change in every sample: a rudder or a propeller may be held."""


class Prior(NamedTuple):
    """What is known of a number before free runs of a model are seen.

    sd : standard deviation in its natural unit (s in ship lengths sailed, L/U; m/s in the ship's speed; rad/s in U/L;
    others as they are); 0: free runs are not asked for it.  trials : values in that unit at which it is linearised by a
    secant, where its tangent at zero stands for nothing.  entries : instruments that it moves, and needs : states that
    have to be measured, where a check does not say so as a cause.  limit : it is a limit of the rudder's command: its
    inverse is moved, and behind commands only.  angle : it is one of the recorded angle, and none behind commands.
    last : it is preferred only where all else is far worse.  others : further entries by which it may act.
    """

    sd: float
    trials: tuple[float, ...] = ()
    entries: tuple[str, ...] = ()
    needs: tuple[str, ...] = ()
    limit: bool = False
    angle: bool = False
    last: bool = False
    others: tuple[tuple[str, ...], ...] = ()


class Check(ABC):
    """Base class of all that can be wrong; subclasses set the class attributes.

    id : public identifier.  where : part of the chain, as `diagnosis.causes.base.WHERE`, or record.
    unit : of its sizes.  separate_by : what would tell it from its rivals.
    stage : where it is looked for, as a reason why a model's residuals are not asked for it.
    is_cause : whether a diagnosis names it as a cause of its bank, beside telling what was checked.
    prior : of its number, in free runs of a model.
    beyond : variable of a regime (`models.regimes`) beyond whose threshold it acts, and the size that the threshold is.
    """

    id: ClassVar[str]
    where: ClassVar[str] = "record"
    unit: ClassVar[str] = "1"
    separate_by: ClassVar[str | None] = None
    stage: ClassVar[str] = "looked for in the records themselves, without a model"
    is_cause: ClassVar[bool] = False
    prior: ClassVar[Prior] = Prior(0.0)
    beyond: ClassVar[tuple[str, str] | None] = None

    @property
    def physics(self) -> str:
        """What it is, in words and as an equation."""
        return cleandoc(next((c.__doc__ for c in type(self).__mro__ if c.__doc__), ""))

    @property
    def describes_hull(self) -> bool:
        """Whether it describes the hull, as the base model's own numbers do."""
        return self.where == "hull"

    def __repr__(self) -> str:
        return self.id

    def __reduce__(self):
        return type(self), ()

    def __eq__(self, other: object) -> bool:
        return type(self) is type(other)

    def __hash__(self) -> int:
        return hash(self.id)


class FileCheck(Check):
    """Base class of faults that one record's file shows.

    rank : checks of lower rank are looked for first; the others see what they corrected.
    ends : a fault of this kind that stands leaves the later checks nothing to compare.
    of_logger : it is one of the logger or the export, so that where it stands in one record, none can be trusted.
    """

    rank: ClassVar[int] = 50
    ends: ClassVar[bool] = False
    of_logger: ClassVar[bool] = False

    @abstractmethod
    def find(self, record: Record) -> list[Fault]:
        """Faults of this kind in one record."""


class ChannelCheck(FileCheck):
    """Base class of faults that each column of a sensor shows by itself."""

    def find(self, record: Record) -> list[Fault]:
        return [fault for name in SENSED if record.has(name) for fault in self.of_channel(record, name)]

    @abstractmethod
    def of_channel(self, record: Record, name: str) -> Iterable[Fault]:
        """Faults of this kind in one column that the record has."""


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
    is_cause = True

    @abstractmethod
    def find(self, records: Sequence[Record], starboard: float) -> tuple[list[ColumnFault], list[Record]]:
        """Faults of this kind, and the records with them corrected.

        starboard : 1 where a positive rudder is to turn the ship to starboard, -1 to port.
        """


class SensorError(Check):
    """Base class of sensor errors that show between channels that must agree.

    turn, track, log : what it leaves between heading and yaw rate, between positions and velocities, and between
    positions along the heading and a log that measures no sway; track_without_model : as track, where a model's filter
    is not to be asked for it.
    together : what it leaves between positions and velocities, sway or not, of sizes that act together; the last one
    has to matter, and all have to explain more than a scale error.
    track_rivals : causes that the track alone cannot tell from it.  least_turn : range of headings, rad, from which it
    can be told.  drifts : it may have another sign in another record, as the zero of a rate gyro.
    farthest : size beyond which it is none of an instrument: then something else is wrong with a channel.
    corrects : columns that its own `corrected_for`, if it has one, needs.
    """

    where = "sensor"
    turn: ClassVar[tuple[SensorEffect[Turn], ...]] = ()
    track: ClassVar[tuple[SensorEffect[Path], ...]] = ()
    log: ClassVar[tuple[SensorEffect[Log], ...]] = ()
    track_without_model: ClassVar[tuple[SensorEffect[Path], ...]] = ()
    together: ClassVar[tuple[SensorEffect[Path | Log], ...]] = ()
    track_rivals: ClassVar[tuple[str, ...]] = ()
    least_turn: ClassVar[float] = 0.0
    drifts: ClassVar[bool] = False
    farthest: ClassVar[float] = float("inf")
    corrects: ClassVar[tuple[str, ...]] = ()


# ---- faults
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
