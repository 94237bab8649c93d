"""Records as one stage of a diagnosis passes them to the next: behind what their files and channels show, before any
hull model is asked."""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np

from ..checks.base import cleaned
from ..checks.check import cleaned_of, compared, distinct, examine_each, with_right_revolutions
from ..checks.columns import RudderSign, to_other_side
from ..checks.comparison.chains import chains
from ..checks.comparison.drift import current_finding
from ..checks.comparison.selection import of_sizes
from ..checks.files.repeats import ConstantChannel
from ..checks.registry import file_checks
from ..checks.result import NORMAL_90, merged
from ..datasets.columns import INPUTS
from ..datasets.instruments import corrected
from ..estimation.diagnosis_only.rudder_scale import rudder_doubt
from ..models.errors import BadInput, CannotFit
from ..models.instruments import combined
from ..models.memory import require_memory
from ..models.time_scale import ship_length_s
from .causes.registry import causes
from .causes.surroundings import Current
from .report.bank import of_sensor

if TYPE_CHECKING:
    from ..checks.base import Check, Fault
    from ..checks.comparison.selection import Compared, Sizes
    from ..checks.result import CheckFinding
    from ..datasets.record import Record
    from ..models.model import Model
    from .options import Options
    from .result import Finding

SPEED = "surge_m_s"
LONGEST, LONGEST_OF_RESPONSE = 15_000, 30_000
"""Samples that one record of a 3-DOF and of a response model may have: those of hours, in which a log does more than
manoeuvres; more could take over two minutes."""
LARGEST = 4 * 2**30
"""Memory, bytes, that the records of one diagnosis may need."""
SAMPLE_BYTES, STATE_BYTES = 16_000, 8_000
"""Memory of a sample and of each of its states, not less than measured: 57 kB a sample of six states, 31 of three."""
FINEST = 0.03
"""Finest sampling of the records of a filter, in ship lengths sailed."""


@dataclass(frozen=True)
class Prepared:
    """Records in the model's rudder sign with what was corrected: gross faults, and what channels show of sensors.

    faults : of whole columns, by the id of their check.  few : those that fewer than half of the records have, with
    these: no instruments of a model, as the others are right as they are.
    checked : what the checks of the files say, corrected where they can be.
    findings, removed : what channels show of their sensors, and these sizes as instruments.  unshown : sizes that no
    instrument of a model has (a compass deviation, late positions).  tested : cause (id) that the channels were asked
    for -> statistic (z squared) of the evidence by itself.
    decided : causes (ids) that the sensors' channels have decided on without a model.
    current : that positions drift against heading and log, which no error of these explains.
    derived : record name -> columns that are made from each other: they are not compared.
    recorded : the held-out records as they were read.
    """

    train: list[Record]
    held_out: list[Record]
    faults: Mapping[str, Fault] = field(default_factory=dict)
    few: Mapping[str, Sequence[str]] = field(default_factory=dict)
    checked: tuple[CheckFinding, ...] = ()
    findings: tuple[Finding, ...] = ()
    removed: dict[str, float] = field(default_factory=dict)
    unshown: tuple[Sizes, ...] = ()
    tested: dict[str, float] = field(default_factory=dict)
    decided: frozenset[str] = frozenset()
    current: Finding | None = None
    derived: Mapping[str, set[str]] = field(default_factory=dict)
    recorded: Sequence[Record] = ()

    def behind_sensors(self, only: Collection[Check] | None) -> Prepared:
        """The records behind what all channels show of their sensors; only : errors that are looked for (None: all).

        Several stages ask for it: it is computed once.
        """
        key = None if only is None else frozenset(only)
        if key not in self._behind:
            bare = replace(self, train=distinct(self.train), tested={})
            done = bare.compared(only)
            self._behind[key] = replace(done, tested=self.tested | done.tested, decided=frozenset(done.tested))
        return self._behind[key]

    @cached_property
    def _behind(self) -> dict[frozenset[Check] | None, Prepared]:
        return {}

    def compared(self, only: Collection[Check] | None = None, positions_only: bool = False) -> Prepared:
        """Compare channels along all chains, or those of positions, and correct the records one after the other.

        Training records are corrected by sizes of their own where these differ, held-out ones by the mean; delays
        too small to matter are corrected and not told.
        """
        ids, done = {c.id: c for c in causes().values() if only is None or c in only}, self
        along = [chain for chain in chains(ids) if chain.of_positions or not positions_only]
        for comparison, train in compared(along, self.train, self.derived, []):
            if comparison.absurd is not None:
                break
            findings = [of_sensor(f, ids) for f in of_sizes(comparison) if f.material]
            drift = _current(comparison) if comparison.chain.of_positions and Current.id in ids else None
            tested = dict(done.tested)
            for option, z in comparison.tested:
                tested[option.cause.id] = max(z**2, tested.get(option.cause.id, 0.0))
            done = replace(
                done,
                train=train,
                held_out=[comparison.without(r, own=False) for r in done.held_out],
                findings=(*done.findings, *findings),
                current=done.current or drift,
                removed=combined(done.removed, _instruments([s for s in comparison.new if s.material])),
                unshown=(*done.unshown, *(s for s in comparison.removed if s.material and not _is_shown(s))),
                tested=tested,
            )
        return done

    @property
    def instruments(self) -> dict[str, float]:
        """What was corrected, as instruments of a model."""
        every = (fault.instruments for cause, fault in self.faults.items() if cause not in self.few)
        return {name: value for own in every for name, value in own.items()} | self.removed

    def put_back(self, records: Sequence[Record]) -> list[Record]:
        """Records as they were read, but for what no instrument of a model can show: columns in another unit, with the
        other sign, or under each other's names are as they should be."""
        wrong = {f.cause for f in self.checked if f.corrected and not f.blanked}
        wrong -= {name for name, fault in self.faults.items() if fault.instruments and name not in self.few}
        right, turned = cleaned_of(records, wrong), self.few.get(RudderSign.id, ())
        right = [r.with_channels(**to_other_side(r)) if r.name in turned else r for r in right]
        for s in self.unshown:
            right = [s.option.corrected_for(r, np.array([mean.of_another for mean in s.means])) for r in right]
        return right


def _current(comparison: Compared) -> Finding | None:
    """A steady drift of the positions against the velocities that matters and has no rival; None without one."""
    with suppress(CannotFit):
        finding = current_finding(comparison)
        if finding is not None and finding.material and not finding.tied_with:
            speeds = [s for s in finding.sizes if s.parameter == Current.size_name]
            z = max(2.0 * NORMAL_90 * s.value / max(s.high - s.low, 1e-12) for s in speeds)
            return of_sensor(replace(finding, z=z), {finding.cause})
    return None


def _is_shown(s: Sizes) -> bool:
    """Whether an instrument of a model shows an error."""
    return any(effect.instruments for effect in s.option.effects)


def _instruments(sizes: Sequence[Sizes]) -> dict[str, float]:
    """Sizes that a further record is expected to have, as instruments of a model."""
    effects = (pair for s in sizes for pair in zip(s.option.effects, s.means, strict=True))
    return {slot: x for effect, mean in effects if (x := mean.of_another) for slot in effect.instruments}


def corrected_records(model: Model, train: Sequence[Record], held_out: Sequence[Record], options: Options) -> Prepared:
    """Records behind the model's instruments, with gross faults and (where the model knows no track) sensors
    corrected."""
    right, units = with_right_revolutions(distinct([*train, *held_out]))
    done = examined(prepared(right, model, options), model)
    sides = done.train[: len(train)], done.train[len(train) :]
    recorded = [replace(r, name=own.name) for r, own in zip(right[len(train) :], held_out, strict=True)]
    checked = (*units, *done.checked)
    done = replace(done, train=sides[0], held_out=sides[1], recorded=recorded, checked=checked)
    if {"v", "x", "y"} <= set(model.states):
        return done
    return done.compared(options.causes(), positions_only=True)


def ready_records(
    model: Model, train: Sequence[Record], held_out: Sequence[Record], options: Options
) -> tuple[Prepared, tuple[str, ...]]:
    """The records of a diagnosis or a calibration without those that stand in doubt, and a sentence for each of these.

    Raises
    ------
    BadInput : no training record.
    """
    if not train:
        raise BadInput("no training record", hint="give at least one")
    return without_doubtful(corrected_records(model, train, held_out, options))


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


def thinned(records: Sequence[Record], model: Model) -> list[Record]:
    """Records of a ship with a length and a speed, sampled no finer than FINEST: more samples would only cost time."""
    try:
        step_s = FINEST * ship_length_s(model)
    except CannotFit:
        return list(records)
    return [record.thinned(max(1, int(step_s / record.dt + 1e-9))) for record in records]


def examined(records: Sequence[Record], model: Model) -> Prepared:
    """Check the files of records behind a model's instruments, in its sign of the rudder: those of training with
    faults of their files corrected as far as possible, what matters of these, and the faults of whole columns."""
    with np.errstate(all="ignore"):
        done = examine_each(distinct(records), file_checks())
        findings = tuple(_judged(f, model) for f in merged(done.findings) if f.material)
        faults = dict(sorted(done.faults.items(), key=lambda item: item[1].statistic))
        owners = {n: dict.fromkeys(r for f in done.findings if f.cause == n for r in f.records) for n in faults}
        standing = any(f.standing for f in findings)
        turned = {} if standing else RudderSign().find(done.records)
    current = [cleaned(r, [turned[r.name]]) if r.name in turned else r for r in done.records]
    if turned:
        faults[RudderSign.id], owners[RudderSign.id] = next(iter(turned.values())), dict.fromkeys(turned)
    doubt = None if standing else rudder_doubt(current, model)
    findings = findings if doubt is None else (*findings, doubt)
    few = {name: tuple(own) for name, own in owners.items() if 2 * len(own) < len(done.records)}
    return Prepared(current, [], faults, few, findings, derived=done.derived)


def _judged(finding: CheckFinding, model: Model) -> CheckFinding:
    """The finding; that of a speed which never changes, and is in the record, stands in the way of a model whose forces
    follow the speed."""
    dead = finding.cause == ConstantChannel.id and finding.blanked > 0 and SPEED in finding.channels
    return replace(finding, standing=True) if dead and model.is_3dof else finding


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


def require_room(model: Model, prepared: Prepared) -> None:
    """Refuse records that are too long before anything of size is computed.

    Raises
    ------
    BadInput : a record has more samples than one may, or their filter needs more memory than is free, or than LARGEST.
    """
    records = thinned([*prepared.train, *prepared.held_out], model)
    longest, limit = max(records, key=lambda record: record.n), LONGEST if model.is_3dof else LONGEST_OF_RESPONSE
    if longest.n > limit:
        hint = f"cut out the manoeuvres, or take a longer step: at most {limit} samples a record"
        raise BadInput(f"{longest.name}: {longest.n} samples are too many for one record of a diagnosis", hint=hint)
    samples = sum(record.n for record in records)
    of_sample = SAMPLE_BYTES + STATE_BYTES * len(model.states)
    what = f"{samples} samples of {len(records)} record{'s' if len(records) > 1 else ''}"
    require_memory(samples * of_sample, what)
    most = LARGEST // of_sample
    if samples > most:
        hint = f"cut out the manoeuvres, or take a longer step: at most {most} samples of this model"
        raise BadInput(f"{what} are too many for one diagnosis", hint=hint)
