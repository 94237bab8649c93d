"""Findings of `check` from what was computed: sentences, sizes by record and over all, whether they matter."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from ..datasets.columns import HEADING, VELOCITIES
from ..models.errors import CannotFit
from .base import Check
from .comparison.drift import FLOOR, Deviation, Drift, drifts, interval, is_there, rivals
from .comparison.selection import DIFFERENT, TIE, Compared, Sizes
from .registry import check_of, sensor_errors
from .result import NORMAL_90, CheckFinding, Size
from .sensors import CurrentDrift

if TYPE_CHECKING:
    from ..datasets.record import Record
    from .base import Fault

DRIFT_SHARE = 0.005
"""Share of the ship's speed from which a drift matters."""
SHOWN = 3


def of_fault(entry: Check, fault: Fault, record: Record) -> CheckFinding:
    """A fault of one record's file as a finding."""
    return CheckFinding(
        entry.id,
        "file",
        (record.name,),
        fault.channels,
        tuple(replace(size, record=record.name) for size in fault.sizes),
        fault.evidence,
        separate_by=entry.separate_by,
        material=fault.material,
        corrected=fault.corrected,
        standing=fault.standing and fault.material,
        biases=fault.material and (fault.corrected if fault.biases is None else fault.biases),
        blanked=sum(stop - max(start, 0) for _, start, stop in fault.blanks),
    )


def merged(findings: Sequence[CheckFinding]) -> list[CheckFinding]:
    """Findings of the same cause in the same columns of several records as one, those that matter first."""
    groups: dict[tuple, list[CheckFinding]] = {}
    for f in findings:
        groups.setdefault((f.cause, f.channels), []).append(f)
    out = [_together(group) for group in groups.values()]
    return sorted(out, key=lambda f: not f.material)


def _together(group: Sequence[CheckFinding]) -> CheckFinding:
    first = next((f for f in group if f.material), group[0])
    said = [f.evidence for f in group] if len(group) == 1 else [f"{f.records[0]}: {f.evidence}" for f in group]
    more = f"; and {len(said) - SHOWN} more" if len(said) > SHOWN else ""
    return replace(
        first,
        records=tuple(dict.fromkeys(r for f in group for r in f.records)),
        sizes=tuple(s for f in group for s in f.sizes),
        evidence="; ".join(said[:SHOWN]) + more,
        material=any(f.material for f in group),
        corrected=any(f.corrected for f in group),
        standing=any(f.standing for f in group),
        biases=any(f.biases for f in group),
        blanked=sum(f.blanked for f in group),
    )


def of_sizes(done: Compared) -> list[CheckFinding]:
    """Sensor errors that a comparison selected, those that matter first."""
    out = [_of_sizes(done, s) for s in done.sizes]
    return sorted(out, key=lambda f: not f.material)


def _of_sizes(done: Compared, s: Sizes) -> CheckFinding:
    names, sizes = [r.name for r in done.records], []
    for k, (effect, mean) in enumerate(zip(s.option.effects, s.means, strict=True)):
        sizes.append(Size(effect.parameter, mean.value, mean.low, mean.high, effect.unit))
        known = np.isfinite(s.each[:, k])
        sizes += [
            Size(effect.parameter, v, v - NORMAL_90 * sd, v + NORMAL_90 * sd, effect.unit, name)
            for v, sd, name in zip(
                s.each[known, k].tolist(), s.spread[known, k].tolist(), np.array(names)[known].tolist(), strict=True
            )
        ]
    entry, p_equal = s.option.cause, min(m.p_equal for m in s.means)
    differs = p_equal < DIFFERENT and len(names) > 1
    tied = [o.cause.id for o in s.rivals] + list(entry.track_rivals)
    said = f"{done.chain.title}: z = {s.z:.1f} over {len(names)} record{'s' if len(names) > 1 else ''}"
    said += f"; late: {_late(s)}" if s.option.effects[0].delay else ""
    said += f"; differs between records (p = {p_equal:.1g}): not one cause" if differs else ""
    return CheckFinding(
        entry.id,
        "sensors",
        tuple(names),
        done.chain.needed,
        tuple(sizes),
        said,
        tuple(dict.fromkeys(tied)),
        entry.separate_by,
        s.material,
        s.z,
        p_equal if len(names) > 1 else None,
    )


def _late(s: Sizes) -> str:
    slots = s.option.effects[0].instruments or (s.option.cause.id,)
    names = [slot.removesuffix("_delay").replace("_", " ") for slot in slots]
    return names[0] if len(names) == 1 else f"{', '.join(names[:-1])} and {names[-1]}"


def of_drift(done: Compared) -> list[CheckFinding]:
    """A steady drift of the records, or the sensor error that explains it with fewer numbers.

    Raises
    ------
    CannotFit : no sea drifts so fast.
    """
    chosen = [s.option for s in done.sizes if s.material]
    of_records = drifts(done.chain, done.corrected, chosen)
    if not is_there(of_records):
        return []
    columns = [n for n in VELOCITIES if n in done.chain.integrated]
    speeds = [float(np.linalg.norm([np.nanmean(r.column(n)) for n in columns])) for r in done.records]
    near = [] if chosen else rivals(done.chain, done.corrected, done.chain.options)
    sizes = [size for d in of_records for size in _drift_sizes(d)]
    material = any(np.hypot(*d.velocity) > DRIFT_SHARE * v for d, v in zip(of_records, speeds, strict=True))
    tied = [o.cause.id for o, _ in near]
    tied += [name for name in CurrentDrift.track_rivals if chosen == [] and len(of_records) == 1 and name not in tied]
    rivals_of = {error.id: error.track_rivals for error in sensor_errors()}
    best = of_records[int(np.argmin([d.p for d in of_records]))]
    speed, low, high, towards = interval(best)
    entry = CurrentDrift()
    if speed > entry.farthest:
        raise CannotFit(f"the positions of {best.record} would drift by {speed:.3g} m/s against heading and log")
    said = (
        f"positions drift against heading and log by {speed:.3g} m/s [{low:.3g}, {high:.3g}] towards "
        f"{np.rad2deg(towards) % 360.0:.0f} deg in {best.record}: a current, if the log measures through the water"
    )
    if near and near[0][1] > -TIE and len(of_records) > 1:
        said += f"; one {near[0][0].cause.id} for all records explains it as well"
    return [
        CheckFinding(
            "current",
            "sensors",
            tuple(d.record for d in of_records),
            done.chain.needed,
            tuple(sizes),
            said,
            tuple(dict.fromkeys(x for name in tied for x in (name, *rivals_of.get(name, ())))),
            entry.separate_by,
            material,
        )
    ]


def _drift_sizes(drift: Drift) -> list[Size]:
    speed, low, high, towards = interval(drift)
    half = min((high - low) / (2.0 * max(speed, 1e-300)), np.pi)
    return [
        Size("speed", speed, low, high, "m/s", drift.record),
        Size("towards", towards, towards - half, towards + half, "rad", drift.record),
    ]


def of_deviation(deviation: Deviation | None) -> list[CheckFinding]:
    """A drift angle that goes with the heading, as a finding."""
    if deviation is None:
        return []
    entry = check_of("compass_deviation")
    up_to, share = np.rad2deg(deviation.amplitude), 100.0 * deviation.share
    said = (
        f"the drift angle goes with the heading, by up to {up_to:.2g} deg (z = {deviation.z:.1f}); that explains "
        f"{share:.0f} % of the sway that turning leaves; leeway would look alike"
    )
    tied = ("wind", "current") if deviation.like_current else ("wind",)
    columns = (HEADING, *VELOCITIES)
    material = deviation.amplitude > FLOOR
    return [
        CheckFinding(
            entry.id,
            "sensors",
            deviation.records,
            columns,
            deviation.sizes,
            said,
            tied,
            entry.separate_by,
            material,
            deviation.z,
        )
    ]
