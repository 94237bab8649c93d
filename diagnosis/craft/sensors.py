"""What the channels of a craft's records show of their sensors, before a model is built of them.

Whole columns in another unit, with the other sign or under another name are corrected, and samples beyond the gyro's
range left out; errors of the yaw rate against the heading are corrected, as a gain of the gyro would be one of the
craft; others are told.  A record whose rudder or command turns the craft to the other side than in most others has it
with the other sign.
"""

from __future__ import annotations

from collections.abc import Sequence
from contextlib import suppress
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from ...checks.base import UNUSABLE
from ...checks.check import cleaned_of, distinct, examine
from ...checks.columns import RudderSign, to_other_side
from ...checks.comparison.drift import deviation_finding
from ...checks.files.outliers import YawRateSaturation
from ...checks.files.repeats import FrozenSamples
from ...checks.files.rudder_response import fitted, means_of
from ...checks.result import merged, sentence_of
from ...checks.sensors import CompassDeviation
from ...datasets.columns import RUDDERS
from ..causes.registry import causes
from ..prepared import Prepared
from ..report.bank import of_columns, of_left_out_samples, of_sensor

if TYPE_CHECKING:
    from ...checks.result import CheckFinding
    from ...datasets.record import Record
    from ..result import Finding

GYRO = ("yaw_rate_scale", "yaw_rate_bias", "yaw_rate_delay")
"""Errors of sensors that are corrected."""
COLUMNS = ("channel_sign", "channel_swap", "earth_frame_velocity", "heading_lag", "heading_zero", "wrong_unit")
SATURATED = YawRateSaturation.id
"""Faults of whole columns that are corrected, and of samples that are left out."""
CORRECTED = (*COLUMNS, SATURATED, *GYRO)
"""All that is corrected."""
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
    every: Sequence[Record] = [*train, *held_out]
    files = [f for f in merged(examine(distinct(every)).findings) if f.material]
    columns, every = _with_right_columns(every, files)
    names = {r.name for r in against_the_others(every)}
    every = [r.with_channels(**to_other_side(r)) if r.name in names else r for r in every]
    turned = "the rudder or command has the other sign than in the other records, and was turned."
    notes = [f"{name}: {turned}" for name in sorted(names)]
    notes += [f"{sentence_of(f)}." for f in files if f.cause in TOLD and not names & {*f.records}]
    bare = Prepared([*every[: len(train)]], [*every[len(train) :]])
    seen = bare.compared()
    findings = seen.findings
    if CompassDeviation.id not in {f.cause for f in findings}:
        with suppress(*UNUSABLE):
            pattern = deviation_finding([*seen.train, *seen.held_out], {f.cause for f in findings})
            findings += () if pattern is None else (of_sensor(pattern, causes()),)
    wrong = {f.cause for f in findings} & {*GYRO}
    done = bare.compared([causes()[name] for name in wrong]) if wrong else bare
    return Sensors(done.train, done.held_out, (*columns, *findings), done.removed, notes)


def _with_right_columns(
    records: Sequence[Record], files: Sequence[CheckFinding]
) -> tuple[list[Finding], Sequence[Record]]:
    """What is told of whole columns and of samples beyond the gyro's range, and the records corrected for them.

    files : faults of the records' files that matter.
    """
    wrong = {f.cause for f in files if f.corrected} & {*COLUMNS, SATURATED}
    if not wrong:
        return [], records
    findings = [of_columns(name, files, records) for name in COLUMNS if name in wrong]
    findings += [of_left_out_samples(SATURATED, files, records)] if SATURATED in wrong else []
    return findings, cleaned_of(distinct(records), wrong)


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
