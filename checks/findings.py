"""Findings of `check` from what was computed: sentences, sizes by record and over all, whether they matter."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from .comparison.selection import DIFFERENT, Compared, Sizes
from .result import NORMAL_90, CheckFinding, Size

if TYPE_CHECKING:
    from ..datasets.record import Record
    from .base import Check, Fault

SHOWN = 3


def of_fault(entry: Check, fault: Fault, *records: Record) -> CheckFinding:
    """A fault of a record's file, or of several records together, as a finding."""
    first = records[0]
    lost = (np.isnan(new) & np.isfinite(first.column(name)) for name, new in fault.columns.items())
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
    said += f"; late: {_late(s)}" if s.option.is_delay else ""
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
