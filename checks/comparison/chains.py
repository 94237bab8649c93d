"""The comparisons that need no hull model, as whitened regressions: heading against yaw rate, track against log.

psi' = r and (north, east)' = R(psi) (surge, sway) hold for any ship; of a log that measures no sway, the part along the
heading.  What the channels leave of them is regressed on what each sensor error would leave; noise is white in heading
and positions, and a random walk from the noise of rates and velocities.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Sequence
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from ...datasets.columns import HEADING, POSITIONS, TRACK, TURN, VELOCITIES
from ...datasets.instruments import corrected
from ..integrity.runs import never_changes
from ..registry import sensor_errors
from .blocks import LONGEST_GAP, Sums, sums_of, whitened_steps
from .motion import Effect, Motion, log_of, path_of, turn_of

if TYPE_CHECKING:
    from ...datasets.record import Record
    from ..base import SensorError

FEWEST = 60
"""Known samples below which a comparison is not made."""


class Option(NamedTuple):
    """A cause with the effects, one for each of its sizes, by which it may act in a chain."""

    cause: SensorError
    effects: tuple[Effect, ...]

    @property
    def is_delay(self) -> bool:
        """Whether its size is a delay."""
        return self.effects[0].delay

    def corrected_for(self, record: Record, values: np.ndarray) -> Record:
        """The record with an error of these sizes (k,) removed from the columns that it has."""
        own = getattr(self.cause, "corrected_for", None)
        if own is not None:
            return own(record, values) if all(map(record.has, self.cause.corrects)) else record
        pairs = zip(self.effects, values.tolist(), strict=True)
        return corrected(record, {slot: v for effect, v in pairs for slot in effect.instruments})


class Chain(NamedTuple):
    """One comparison: what it is called, the columns it needs, how a record becomes a motion, and its options.

    integrated, target : columns that are integrated, and those they are compared with.  opposed : columns of which one
    must not be made from the others.  without : columns of which a record must have none (another chain takes it then).
    instead : options that explain the comparison in the place of others (`selection.compare`).
    """

    title: str
    needed: tuple[str, ...]
    integrated: tuple[str, ...]
    target: tuple[str, ...]
    opposed: tuple[str, ...]
    motion: Callable[[Record], Motion]
    options: tuple[Option, ...]
    instead: tuple[Option, ...]
    without: tuple[str, ...] = ()

    @property
    def of_positions(self) -> bool:
        """Whether positions are the target, of which a current may carry the ship away."""
        return self.target == POSITIONS

    def taken(self, records: Sequence[Record]) -> list[Record]:
        """The records that are not another chain's."""
        return [r for r in records if not any(map(r.has, self.without))]


def chains(only: Collection[str] | None = None) -> tuple[Chain, ...]:
    """All comparisons, in the order in which records are corrected for what they show.

    only : sensor errors (ids) that are looked for; None: all.
    """
    errors = [c for c in sensor_errors() if only is None or c.id in only]
    turns, others, curves = (
        tuple(Option(c, effects) for c in errors if (effects := effects_of(c)))
        for effects_of in (lambda c: c.turn, lambda c: c.turn_instead, lambda c: c.together)
    )
    tracks, logs = (tuple(Option(c, (e,)) for c in errors for e in getattr(c, name)) for name in ("track", "log"))
    speeds, log = (HEADING, *VELOCITIES), (HEADING, "surge_m_s")
    along = "positions along the heading against the log"
    return (
        Chain("heading against yaw rate", TURN, TURN[1:], TURN[:1], TURN, turn_of, turns, others),
        Chain("positions against velocities", TRACK, speeds, POSITIONS, TRACK[1:], path_of, tracks, curves),
        Chain(along, (*log, *POSITIONS), log, POSITIONS, (*log[1:], *POSITIONS), log_of, logs, curves, ("sway_m_s",)),
    )


def rows_of(chain: Chain, record: Record, options: Sequence[Option]) -> tuple[np.ndarray, np.ndarray, int]:
    """Whitened rows of a record, what the channels leave, the effects' and the drift's columns (1 + k + d, N), where
    each row stands in the record (N,), from 0 to 1, and d."""
    motion = chain.motion(record)
    effects = [effect.column(motion) for o in options for effect in o.effects]
    series = np.stack([motion.position - motion.run, *effects, *motion.drift])
    axes = np.stack([series.real, series.imag]) if np.iscomplexobj(motion.position) else series[None]
    known = np.all([np.isfinite(record.column(name)) for name in chain.target], axis=0)
    own = np.flatnonzero(known)
    size = float(np.ptp(axes[:, 0])) or 1.0
    white, walk = max(motion.white, 1e-9 * size), max(motion.walk, 1e-12 * size)
    time = motion.time[own]
    joined = _joined(chain, record, own)
    rows = whitened_steps(axes[:, :, own].reshape(-1, own.size), joined, white, walk * np.sqrt(np.diff(time)))
    place = (0.5 * (time[1:] + time[:-1])[joined] - time[0]) / max(time[-1] - time[0], 1e-12)
    return np.hstack(np.split(rows, len(axes))), np.tile(place, len(axes)), len(motion.drift)


def sums(chain: Chain, record: Record, options: Sequence[Option]) -> Sums:
    """Sums of a record's rows over its blocks."""
    return sums_of(*rows_of(chain, record, options))


def why_not(chain: Chain, record: Record, derived: Collection[str] = ()) -> str | None:
    """Why a record, some columns of which are made from each other, cannot be compared, as a sentence; None where it
    can."""
    if {*chain.opposed} <= {*derived}:
        return f"in {record.name} one is made from the other, so they cannot check each other"
    lacking = [name for name in chain.needed if not record.has(name)]
    if lacking:
        return f"{record.name} has no column {' and '.join(lacking)}"
    known = np.all([np.isfinite(record.column(name)) for name in chain.needed], axis=0)
    if known.sum() < FEWEST:
        return f"{record.name} has {known.sum()} samples with all of {', '.join(chain.needed)}; {FEWEST} are needed"
    still = [name for name in chain.needed if never_changes(record.column(name))]
    if still:
        return f"{' and '.join(still)} of {record.name} never changes"
    return None


def _joined(chain: Chain, record: Record, own: np.ndarray) -> np.ndarray:
    """Steps between the samples `own` over which the integrated channels are known."""
    time, longest = record.time_s, LONGEST_GAP * float(np.median(np.diff(record.time_s)))
    joined = np.diff(time[own]) <= longest
    for name in chain.integrated:
        known = np.isfinite(record.column(name))
        before = np.maximum.accumulate(np.where(known, np.arange(time.size), 0))
        after = np.minimum.accumulate(np.where(known, np.arange(time.size), time.size - 1)[::-1])[::-1]
        gap = time[after] - time[before] > longest
        joined &= ~(gap[own][1:] | gap[own][:-1])
        joined &= (own[1:] > np.argmax(known)) & (own[1:] <= time.size - 1 - np.argmax(known[::-1]))
    return joined
