"""What the channels of a craft's records show of their sensors, before a model is built of them.

Errors of the yaw rate against the heading are corrected, as a gain of the gyro would be one of the craft; others are
told.  A record whose rudder or command turns the craft to the other side than in most others has it with the other
sign.
"""

from __future__ import annotations

from collections.abc import Sequence
from contextlib import suppress
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from ...checks.base import UNUSABLE, scaled
from ...checks.check import distinct, examine
from ...checks.columns import RudderSign
from ...checks.comparison.drift import deviation_finding
from ...checks.files.repeats import FrozenSamples
from ...checks.files.rudder_response import fitted, means_of
from ...checks.result import merged, sentence_of
from ...checks.sensors import CompassDeviation
from ...datasets.columns import RUDDERS
from ..causes.registry import causes
from ..prepared import Prepared
from ..report.bank import of_sensor

if TYPE_CHECKING:
    from ...datasets.record import Record
    from ..result import Finding

CORRECTED = ("yaw_rate_scale", "yaw_rate_bias", "yaw_rate_delay")
"""Errors of sensors that are corrected."""
TOLD = (FrozenSamples.id, RudderSign.id)
"""Faults of files and columns that are told: the others leave the model as it is, or were told on reading."""
SURE, BETTER, FEWEST = 3.0, 1.5, 3
"""Standard deviations by which a rudder has to act in every record, ratio of their sum to that of a rudder which acts
to the same side in all, and records, to tell which has it the other way round."""
FARTHEST = 0.1
"""Share of the shortest record up to which the craft may turn later than its order."""


class Sensors(NamedTuple):
    """Records behind what was corrected, all that channels show of their sensors, instruments, and what must be known,
    a sentence each."""

    train: list[Record]
    held_out: list[Record]
    findings: tuple[Finding, ...]
    instruments: dict[str, float]
    notes: list[str]


def behind_sensors(train: Sequence[Record], held_out: Sequence[Record]) -> Sensors:
    """The records as their sensors should have shown them."""
    names = {r.name for r in against_the_others([*train, *held_out])}

    def to_the_side(record: Record) -> Record:
        signs = {name: -1.0 for name in RUDDERS if record.has(name) and record.name in names}
        return record.with_channels(**scaled(record, **signs)) if signs else record

    own, others = ([*map(to_the_side, side)] for side in (train, held_out))
    turned = "the rudder or command has the other sign than in the other records, and was turned."
    notes = [f"{name}: {turned}" for name in sorted(names)]
    of_files = merged(examine(distinct([*own, *others])).findings)
    notes += [f"{sentence_of(f)}." for f in of_files if f.material and f.cause in TOLD]
    bare = Prepared(own, others)
    seen = bare.compared()
    every = seen.findings
    if CompassDeviation.id not in {f.cause for f in every}:
        with suppress(*UNUSABLE):
            pattern = deviation_finding([*seen.train, *seen.held_out])
            every += () if pattern is None else (of_sensor(pattern, causes()),)
    wrong = {f.cause for f in every} & {*CORRECTED}
    done = bare.compared([causes()[name] for name in wrong]) if wrong else bare
    return Sensors(done.train, done.held_out, every, done.removed, notes)


def against_the_others(records: Sequence[Record]) -> list[Record]:
    """Records, less than half of all, in which the craft turns to the other side; none where some does not tell, or
    where all turn to the same side some time later."""
    means = [m for r in records if any(map(r.has, RUDDERS)) and (m := means_of(r)) is not None]
    if len(means) < max(len(records), FEWEST):
        return []
    step_s = min(m.step_s for m in means)
    lags_s = step_s * np.arange(int(FARTHEST * min(m.slope.size * m.step_s for m in means) / step_s) + 1)
    acts = np.array([[fitted(m, round(lag / m.step_s))[0] for m in means] for lag in lags_s.tolist()])
    each, alike = np.abs(acts).sum(axis=1), np.abs(acts.sum(axis=1))
    best = acts[np.argmax(each)]
    few = best > 0.0 if 2 * np.count_nonzero(best > 0.0) < best.size else best < 0.0
    is_sure = np.min(np.abs(best)) > SURE and np.max(each) > BETTER * np.max(alike) and 2 * sum(few) < few.size
    return [r for r, other in zip(records, few.tolist(), strict=True) if other and is_sure]
