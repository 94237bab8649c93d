"""Checks of a record's time stamps, and of channels that stay the same: dead, frozen, or in coarse steps."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from ...datasets.columns import CANONICAL, TRACK, VELOCITIES
from ..base import SENSED, ChannelCheck, Fault, FileCheck, exact, without
from ..integrity.averages import swing
from ..integrity.readings import track_error
from ..integrity.runs import COARSE, frozen_runs, held_rows, never_changes, resolution, runs_of, stuck_runs

if TYPE_CHECKING:
    from ...datasets.record import Record

TURN = 0.5
"""Range of headings, rad, over which every ship loses speed and drifts: a speed that stays the same is none."""
CONFIRMED = 0.01
"""Disagreement of the track, as a share of the way made, below which positions confirm a speed that stays the same."""
FROZEN_SHARE, FROZEN_SAMPLES = 0.02, 20
"""Share of a record, and samples at least, from which a frozen stretch matters, however little the channel jumps."""
SEEN, MATTERS = 0.002, float(np.sqrt(12.0 * 0.005))
"""Shares of a channel's motion from which its steps are told, and from which they matter.  Rounding to steps q adds
white noise of variance q^2/12 (Bennett 1948, Bell Syst. Tech. J. 27, 446).  A slope that is fitted to the channel is
too small by q^2/12 over the mean square of the motion (errors in variables, Fuller 1987, section 1.1): by half a
percent, the floor of a scale, where q is .245 of the motion."""
RATE = "yaw_rate_rad_s"
RATES = (RATE, *VELOCITIES)
"""Channels whose motion is their root mean square; a heading and a position count from any zero."""


class ConstantChannel(FileCheck):
    """A channel that never changes, or never has a value: a dead sensor, or one that was not connected."""

    id, rank = "constant_channel", 0
    separate_by = "a record in which the quantity surely changes"

    def find(self, record: Record) -> list[Fault]:
        faults = [
            Fault(f"{name} is {said}, and is left out", (name,), biases=True) for name, said in record.left_out.items()
        ]
        for name, values in record.channels.items():
            known = values[np.isfinite(values)]
            if not known.size:
                faults.append(Fault(f"{name} has no value at all", (name,)))
            elif known.size > 1 and never_changes(known):
                faults.append(_constant(record, name, float(np.median(known))))
        return faults


def _constant(record: Record, name: str, value: float) -> Fault:
    """A channel that is the same value in every row; a speed that positions confirm is a remark."""
    said = f"{name} is {value:.6g} {CANONICAL[name]} in every row"
    if name in VELOCITIES and record.has(*TRACK) and track_error(record) < CONFIRMED:
        return Fault(f"{said}, and heading and positions show the same velocity", (name,), material=False)
    dead = name in VELOCITIES and swing(record) > TURN
    said += " while the ship turns: no measured speed, leave the column out" if dead else ""
    columns = without(record, name, True) if dead else {}
    return Fault(said, (name,), material=name in SENSED, columns=columns, biases=dead)


class FrozenSamples(ChannelCheck):
    """A channel repeats its last value while the ship moves on: the sensor or the link to it stood still."""

    id, rank, unit = "frozen_samples", 20, "s"
    separate_by = "the sensor's own time stamps"

    def of_channel(self, record: Record, name: str) -> Iterator[Fault]:
        values, time = record.column(name), record.time_s
        runs, rows = frozen_runs(values), held_rows(values)
        equal = runs_of(values) if record.has(RATE) and rows == 1 else []
        stuck = stuck_runs(record.column(RATE)) if equal else []
        inside = [r for r in equal if any(r.start <= s.start + 1 and r.stop >= s.stop - 1 for s in stuck)]
        runs = sorted({r.start: r for r in (*inside, *runs)}.values())
        if runs:
            worst = max(runs, key=lambda r: time[r.stop - 1] - time[r.start])
            start, length = time[worst.start], float(time[worst.stop - 1] - time[worst.start])
            stretches = "1 stretch" if len(runs) == 1 else f"{len(runs)} stretches"
            said = f"{name} repeats one value in {stretches}, the longest from {start:.6g} s for {length:.4g} s"
            repeated = np.zeros(record.n, bool)
            for r in runs:
                repeated[r.start + 1 : r.stop] = True
            least = max(FROZEN_SHARE * record.n, FROZEN_SAMPLES)
            matters = any(r.jump > COARSE or r.stop - r.start > least for r in runs)
            yield Fault(said, (name,), (exact("longest", length, "s"),), matters, without(record, name, repeated))
        if rows > 1:
            said = f"{name} changes only every {rows} rows: it is sampled more slowly than the record"
            yield Fault(said, (name,), (exact("period", rows * record.dt, "s"),), material=False)


class CoarseChannel(ChannelCheck):
    """A channel that is stored in coarse steps: rounded, or of a sensor with few digits.  They matter where they are a
    sizeable part of the motion."""

    id, rank = "coarse_channel", 30
    separate_by = "the sensor's data sheet, or an export with more digits"

    def of_channel(self, record: Record, name: str) -> Iterator[Fault]:
        values = record.continuous(name)
        step = resolution(values)
        if not step:
            return
        motion, what = float(np.nanstd(values)), "standard deviation"
        if name in RATES:
            motion, what = float(np.sqrt(np.nanmean(values**2))), "root mean square"
        if step > SEEN * motion:
            said = f"{name} takes steps of {step:.3g}, {100.0 * step / motion:.1f} % of its {what}"
            yield Fault(said, (name,), (exact("step", step, CANONICAL[name]),), step > MATTERS * motion)


# ---- time stamps
LATE, UNEVEN, MISSING = 0.2, 0.05, 1.5
"""Shares of the median step: from which one stamp is late, steps are uneven, rows are missing."""


class Stamps(NamedTuple):
    """Median step s, rows missing and in how many gaps, longest gap and longest stretch without a gap of more than LONG
    steps, s, late stamps, share of other uneven steps, and the standard deviation of the uneven steps, s."""

    step_s: float
    missing: int
    gaps: int
    longest_s: float
    whole_s: float
    late: np.ndarray
    uneven: float
    spread_s: float


def stamps(time: np.ndarray) -> Stamps:
    """What the times (N,) of a record show, N >= 3."""
    steps = np.diff(time)
    dt = float(np.median(steps))
    gap = steps > MISSING * dt
    off = np.abs(steps - dt)
    pair = (off[:-1] > LATE * dt) & (np.abs(steps[:-1] + steps[1:] - 2.0 * dt) < 0.1 * dt)
    late = np.flatnonzero(pair) + 1
    of_pairs = np.zeros(steps.size, bool)
    of_pairs[late - 1] = of_pairs[late] = True
    uneven = (off > UNEVEN * dt) & ~of_pairs & ~gap
    cuts = np.flatnonzero(steps > LONG * dt)
    starts, ends = np.append(0, cuts + 1), np.append(cuts, time.size - 1)
    rows = np.maximum(np.round(steps[gap & ~of_pairs] / dt) - 1.0, 1.0)
    return Stamps(
        dt,
        int(rows.sum()),
        rows.size,
        float(steps[gap].max(initial=0.0)),
        float(np.max(time[ends] - time[starts])),
        late,
        float(np.mean(uneven)),
        float(np.std(steps[~gap])),
    )


UNEVEN_SHARE = 0.02
MISSING_SHARE = 0.02
MOST, TOO_LONG, WHOLE = 0.5, 0.2, 0.3
"""Share of the rows that may be missing where all gaps are short, and else shares of the record that one gap may take,
and that the longest stretch without a long gap takes at least, for a motion to be followed."""
LONG = 20
"""Steps below which a gap is short."""


class TimeStamps(FileCheck):
    """Time stamps that repeat, go back, come late or irregularly, or rows that are missing."""

    id, rank, unit = "time_stamps", 10, "s"
    ends = True
    separate_by = "the logger's own sample counter"

    def find(self, record: Record) -> list[Fault]:
        if record.n < 3:
            return []
        s, faults = stamps(record.time_s), []
        if s.missing:
            said = f"{s.missing} rows are missing in {s.gaps} gaps of up to {s.longest_s:.4g} s (step {s.step_s:.4g} s)"
            much = s.missing > MISSING_SHARE * record.n
            share = s.missing / (record.n + s.missing)
            short = s.longest_s <= LONG * s.step_s
            duration_s = float(np.ptp(record.time_s))
            torn = share > MOST if short else s.longest_s > TOO_LONG * duration_s or s.whole_s < WHOLE * duration_s
            size = (exact("longest gap", s.longest_s, "s"),)
            faults.append(Fault(said, ("time_s",), size, much or torn, standing=torn))
        if s.late.size:
            at = ", ".join(f"{record.time_s[k]:.6g}" for k in s.late[:3])
            said = f"{s.late.size} stamps come early or late between their neighbours, at {at} s"
            faults.append(Fault(said, ("time_s",)))
        if s.uneven > UNEVEN_SHARE:
            said = f"{100.0 * s.uneven:.0f} % of the steps differ from {s.step_s:.4g} s by more than 5 %"
            faults.append(Fault(said, ("time_s",), (exact("standard deviation of the step", s.spread_s, "s"),)))
        return faults
