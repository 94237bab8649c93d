"""Records as one stage of a diagnosis passes them to the next."""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import TYPE_CHECKING

from ..checks.comparison.chains import chains
from ..datasets.columns import INPUTS
from ..datasets.instruments import corrected
from .channels import Sensors, Shown, sensors_of
from .checked import examined

if TYPE_CHECKING:
    from ..checks.base import Check
    from ..checks.fault import ColumnFault
    from ..checks.result import CheckFinding
    from ..datasets.record import Record
    from ..models.model import Model
    from .options import Options


@dataclass(frozen=True)
class Prepared:
    """Records in the model's rudder sign with what was corrected: gross faults, and what channels show of sensors.

    checked : what the checks of the files found, corrected where they can be.
    decided : causes that the sensors' channels have decided on without a model.
    derived : record name -> columns that are made from each other.
    recorded : the held-out records as they were read.
    """

    train: list[Record]
    held_out: list[Record]
    faults: list[ColumnFault]
    shown: Shown
    checked: tuple[CheckFinding, ...] = ()
    decided: frozenset[Check] = frozenset()
    derived: Mapping[str, set[str]] = field(default_factory=dict)
    recorded: Sequence[Record] = ()

    def sensors(self, only: Collection[Check] | None) -> Sensors:
        """The records behind what channels show of their sensors; only : errors that are looked for (None: all).

        Several stages ask for it: it is computed once.
        """
        key = None if only is None else frozenset(only)
        if key not in self._sensors:
            self._sensors[key] = sensors_of(self.train, self.held_out, only, derived=self.derived)
        return self._sensors[key]

    @cached_property
    def _sensors(self) -> dict[frozenset[Check] | None, Sensors]:
        return {}

    def behind_sensors(self, only: Collection[Check] | None) -> Prepared:
        """The records with the sensors' errors removed that channels show, and what was found of these."""
        sensors = self.sensors(only)
        return replace(
            self,
            train=sensors.train,
            held_out=sensors.held_out,
            shown=self.shown.then(sensors.shown),
            decided=frozenset(sensors.shown.statistics),
        )

    @property
    def instruments(self) -> dict[str, float]:
        """What was corrected, as instruments of a model."""
        faults = {name: value for fault in self.faults for name, value in fault.instruments.items()}
        return faults | self.shown.instruments


def corrected_records(model: Model, train: Sequence[Record], held_out: Sequence[Record], options: Options) -> Prepared:
    """Records behind the model's instruments, with gross faults and (where the model knows no track) sensors
    corrected."""
    records, checked, faults, derived = examined(prepared([*train, *held_out], model, options), model)
    own, others, shown = records[: len(train)], records[len(train) :], Shown()
    if not {"v", "x", "y"} <= set(model.states):
        sensors = sensors_of(own, others, options.causes(), [c for c in chains() if c.of_positions], derived)
        own, others, shown = sensors.train, sensors.held_out, sensors.shown
    return Prepared(own, others, faults, shown, checked, derived=derived, recorded=held_out)


def without_doubtful(records: Prepared) -> tuple[Prepared, tuple[str, ...]]:
    """The records without those that stand in doubt, and a sentence for each that is set aside.

    A doubt is about the record that it was found in: the others are diagnosed.  What is found in half of the training
    records or more is no matter of single records: it sets none aside, and stands.
    """
    own = {r.name for r in records.train}
    single = [f for f in records.checked if f.standing and 2 * len(own & {*f.records}) < len(own)]
    doubts = {name: f.evidence for f in reversed(single) for name in f.records}
    train = [r for r in records.train if r.name not in doubts] or records.train
    held_out = [r for r in records.held_out if r.name not in doubts]
    recorded = [r for r, own in zip(records.recorded, records.held_out, strict=True) if own.name not in doubts]
    left = {r.name for r in (*train, *held_out)}
    aside = tuple(f"{name} is set aside: {said}" for name, said in doubts.items() if name not in left)
    checked = tuple(replace(f, standing=f.standing and bool(left & {*f.records})) for f in records.checked)
    return replace(records, train=train, held_out=held_out, recorded=recorded, checked=checked), aside


def prepared(records: Sequence[Record], model: Model, options: Options) -> list[Record]:
    """Records in the model's rudder sign, behind its instruments, with the chosen channels and the inputs only."""
    out = []
    for record in records:
        turned = corrected(record.turned(model.positive_rudder), model.instruments)
        if options.channels is not None:
            kept = {*options.channels, *INPUTS}
            turned = replace(turned, channels={k: v for k, v in turned.channels.items() if k in kept})
        out.append(turned)
    return out
