"""What a check is: one class whose body is a row of data, and all that is known of it without a hull model; and the
faults that it finds.

A check says what it looks for (its docstring: in words and as an equation), the unit of its sizes, and what would tell
it from its rivals.  `FileCheck` looks at one record, `ColumnCheck` at what whole columns mean, `SensorError` leaves
something between channels that must agree.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field, replace
from inspect import cleandoc
from typing import TYPE_CHECKING, ClassVar, NamedTuple

import numpy as np

from ..datasets.columns import POSITIONS, TURN, VELOCITIES
from ..models.errors import BadInput, CannotFit
from .result import CheckFinding, Size

if TYPE_CHECKING:
    from ..datasets.record import Record
    from .comparison.motion import Effect

SENSED = (*TURN, *VELOCITIES, *POSITIONS)
"""Columns of sensors, which change in every sample: a rudder or a propeller may be held."""


UNUSABLE = (BadInput, CannotFit, ArithmeticError, ValueError, IndexError, np.linalg.LinAlgError)
"""What a computation on records that cannot carry it may raise."""


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
    of_record : whether it is of the record alone, as samples that are no measurements or motion in waves: no number of
    a model, of its rudder or of its sensors stands for it, and it says nothing against the model.
    prior : of its number, in free runs of a model.
    beyond : variable of a regime (`models.regimes`) beyond whose threshold it acts, and the size that the threshold is.
    """

    id: ClassVar[str]
    where: ClassVar[str] = "record"
    unit: ClassVar[str] = "1"
    separate_by: ClassVar[str | None] = None
    stage: ClassVar[str] = "looked for in the records themselves, without a model"
    is_cause: ClassVar[bool] = False
    of_record: ClassVar[bool] = False
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

    of_record = True
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


class ColumnCheck(FileCheck):
    """Base class of checks that show that a whole column means something else; a diagnosis names what they find."""

    stage = "looked for in the records themselves, before all else"
    is_cause = True


class SensorError(Check):
    """Base class of sensor errors that show between channels that must agree.

    turn, track, log : what it leaves between heading and yaw rate (of its sizes together), and each way in which it may
    act between positions and velocities, and between positions along the heading and a log that measures no sway.
    together : what it leaves between positions and velocities, sway or not, of sizes that act together; the last one
    has to matter, and all have to explain more than a scale error.
    turn_instead, instead_of : what it leaves between heading and yaw rate in the place of another error, and the id of
    that one.
    track_rivals : causes that the track alone cannot tell from it.  least_turn : range of headings, rad, from which it
    can be told.  drifts : it may have another sign in another record, as the zero of a rate gyro.
    farthest : size beyond which it is none of an instrument: then something else is wrong with a channel.
    corrects : columns that its own `corrected_for`, if it has one, needs.
    """

    where = "sensor"
    turn: ClassVar[tuple[Effect, ...]] = ()
    track: ClassVar[tuple[Effect, ...]] = ()
    log: ClassVar[tuple[Effect, ...]] = ()
    together: ClassVar[tuple[Effect, ...]] = ()
    turn_instead: ClassVar[tuple[Effect, ...]] = ()
    instead_of: ClassVar[str] = ""
    track_rivals: ClassVar[tuple[str, ...]] = ()
    least_turn: ClassVar[float] = 0.0
    drifts: ClassVar[bool] = False
    farthest: ClassVar[float] = float("inf")
    corrects: ClassVar[tuple[str, ...]] = ()


# ---- faults
@dataclass(frozen=True, eq=False)
class Fault:
    """What is wrong with a record, as a sentence with its figures.

    channels : columns that are concerned.  sizes : numbers of the fault with their intervals.  material : whether it
    would falsify what the record gives; else it is a remark.  columns : the record's columns as they should be, nan
    where samples are no measurements; empty: it cannot be corrected.  standing : while it stands nothing that a model
    says of the hull can be trusted.  biases : a fit to the record as it is would be wrong by it (None: where it can be
    corrected).
    Of a whole column that a diagnosis names: how clearly it shows (in sd, squared), and the instruments of a model that
    has it.
    """

    evidence: str
    channels: tuple[str, ...] = ()
    sizes: tuple[Size, ...] = ()
    material: bool = True
    columns: Mapping[str, np.ndarray] = field(default_factory=dict)
    standing: bool = False
    biases: bool | None = None
    statistic: float = 0.0
    instruments: Mapping[str, float] = field(default_factory=dict)

    @property
    def corrected(self) -> bool:
        """Whether the record can be corrected for it."""
        return self.material and bool(self.columns)


def exact(parameter: str, value: float, unit: str) -> Size:
    """A size that is counted or read off, without an interval."""
    return Size(parameter, float(value), float(value), float(value), unit)


def scaled(record: Record, **factors: float) -> dict[str, np.ndarray]:
    """Columns of a record multiplied by factors."""
    return {name: factor * record.column(name) for name, factor in factors.items()}


def without(record: Record, name: str, wrong: np.ndarray | bool) -> dict[str, np.ndarray]:
    """A column of a record with gaps where samples (N,) are wrong."""
    return {name: np.where(wrong, np.nan, record.column(name))}


def cleaned(record: Record, faults: Iterable[Fault]) -> Record:
    """The record corrected for faults that matter, without columns of which no sample is left; the same where none can
    be."""
    columns = {name: values for fault in faults if fault.material for name, values in fault.columns.items()}
    known = {name: values if np.isfinite(values).any() else None for name, values in columns.items()}
    return record.with_channels(**known) if known else record


def of_fault(entry: Check, fault: Fault, *records: Record) -> CheckFinding:
    """A fault of a record's file, or of several records together, as a finding."""
    first, gaps = records[0], {} if fault.statistic else fault.columns  # another meaning of a column leaves nothing out
    lost = (np.isnan(new) & np.isfinite(first.column(name)) for name, new in gaps.items())
    return CheckFinding(
        entry.id,
        "file",
        tuple(r.name for r in records),
        fault.channels,
        tuple(replace(size, record=first.name) for size in fault.sizes),
        fault.evidence,
        separate_by=entry.separate_by,
        material=fault.material,
        corrected=fault.corrected,
        standing=fault.standing and fault.material,
        biases=fault.material and (fault.corrected if fault.biases is None else fault.biases),
        blanked=sum(int(np.count_nonzero(x)) for x in lost),
    )
