"""The comparisons that need no hull model, as whitened regressions: heading against yaw rate, track against log.

psi' = r and (north, east)' = R(psi) (surge, sway) hold for any ship; of a log that measures no sway, the part along the
heading.  What the channels leave of them is regressed on what each sensor error would leave; noise is white in heading
and positions, and a random walk from the noise of rates and velocities.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from ...datasets.columns import HEADING, POSITIONS, TRACK, TURN, VELOCITIES
from ...datasets.instruments import corrected
from ...datasets.signals import integral, sensor_sd
from ..integrity.runs import never_changes
from ..registry import sensor_errors
from .blocks import LONGEST_GAP, Rows, Sums, sums_of, whitened_steps
from .series import SensedMotion, SensorEffect, log_of, path_of, turn_of

if TYPE_CHECKING:
    from ...datasets.record import Record
    from ..base import SensorError

FEWEST = 60
"""Known samples below which a comparison is not made."""


class Option(NamedTuple):
    """A cause with the effects, one for each of its sizes, by which it may act in a chain."""

    cause: SensorError
    effects: tuple[SensorEffect[Any], ...]

    def corrected_for(self, record: Record, values: np.ndarray) -> Record:
        """The record with an error of these sizes (k,) removed from the columns that it has."""
        own = getattr(self.cause, "corrected_for", None)
        if own is not None:
            return own(record, values) if all(map(record.has, self.cause.corrects)) else record
        pairs = zip(self.effects, values.tolist(), strict=True)
        return corrected(record, {slot: v for effect, v in pairs for slot in effect.instruments})


class Chain(NamedTuple):
    """One comparison: what it is called, the columns it needs, its options, and how a record becomes rows.

    integrated, target : columns that are integrated, and those they are compared with.  opposed : columns of which one
    must not be made from the others.  without : columns of which a record must have none (another chain takes it then).
    motion : record -> its integrated channels.  departure : motion -> (axes, T).  nuisances : motion -> (d, axes, T).
    noise : motion -> standard deviations of the white noise and of the random walk after a second.
    """

    title: str
    needed: tuple[str, ...]
    integrated: tuple[str, ...]
    target: tuple[str, ...]
    opposed: tuple[str, ...]
    options: tuple[Option, ...]
    motion: Callable[[Record], Any]
    departure: Callable[[Any], np.ndarray]
    nuisances: Callable[[Any], np.ndarray]
    noise: Callable[[Any], tuple[float, float]]
    without: tuple[str, ...] = ()

    @property
    def of_positions(self) -> bool:
        """Whether positions are the target, of which a current may carry the ship away."""
        return self.target == POSITIONS

    def taken(self, records: Sequence[Record]) -> list[Record]:
        """The records that are not another chain's."""
        return [r for r in records if not any(map(r.has, self.without))]


def chains() -> tuple[Chain, ...]:
    """All comparisons, in the order in which records are corrected for what they show."""
    return heading_chain(), track_chain(), log_chain()


def heading_chain() -> Chain:
    """Heading against integrated yaw rate."""
    return Chain(
        "heading against yaw rate",
        TURN,
        ("yaw_rate_rad_s",),
        (HEADING,),
        TURN,
        tuple(Option(c, c.turn) for c in sensor_errors() if c.turn),
        turn_of,
        lambda turn: (turn.heading - turn.turned)[None],
        lambda turn: np.zeros((0, 1, turn.time.size)),
        lambda turn: (sensor_sd(turn.heading), sensor_sd(turn.rate) * np.sqrt(turn.step_s)),
    )


def track_chain() -> Chain:
    """Positions against integrated velocities, a steady drift of each record estimated along."""
    return Chain(
        "positions against velocities",
        TRACK,
        (HEADING, *VELOCITIES),
        POSITIONS,
        TRACK[1:],
        tuple(Option(c, (e,)) for c in sensor_errors() for e in (*c.track, *c.track_without_model)),
        path_of,
        lambda path: np.stack([path.north, path.east]) - path.way,
        lambda path: drift_columns(path),
        _track_noise,
    )


def log_chain() -> Chain:
    """Way of the positions along the heading against a log that measures no sway, a steady drift estimated along."""
    return Chain(
        "positions along the heading against the log",
        (HEADING, "surge_m_s", *POSITIONS),
        (HEADING, "surge_m_s"),
        POSITIONS,
        ("surge_m_s", *POSITIONS),
        tuple(Option(c, (e,)) for c in sensor_errors() for e in c.log),
        log_of,
        lambda log: (log.ahead - log.run)[None],
        lambda log: integral(np.stack([np.cos(log.heading), np.sin(log.heading)]), log.time)[:, None],
        lambda log: (log.place_sd, sensor_sd(log.surge) * np.sqrt(log.step_s)),
        without=("sway_m_s",),
    )


def drift_columns(motion: SensedMotion) -> np.ndarray:
    """(2, 2, T) way that a drift of 1 m/s to north and to east makes."""
    zero = np.zeros_like(motion.time)
    return np.stack([np.stack([motion.time, zero]), np.stack([zero, motion.time])])


def rows_of(chain: Chain, record: Record, options: Sequence[Option], drift: bool = True) -> tuple[Rows, np.ndarray]:
    """Whitened rows of a record, and where each stands in it (0 .. 1)."""
    motion = chain.motion(record)
    effects = [effect.column(motion) for o in options for effect in o.effects]
    extra = chain.nuisances(motion) if drift else chain.nuisances(motion)[:0]
    series = np.stack([chain.departure(motion), *effects, *extra])
    known = np.all([np.isfinite(record.column(name)) for name in chain.target], axis=0)
    own = np.flatnonzero(known)
    white, walk = chain.noise(motion)
    size = float(np.ptp(series[0])) or 1.0
    white, walk = max(white, 1e-9 * size), max(walk, 1e-12 * size)
    time = motion.time[own]
    joined = _joined(chain, record, own)
    axes = [
        whitened_steps(series[:, a, own], joined, white, walk * np.sqrt(np.diff(time))) for a in range(series.shape[1])
    ]
    rows, k = np.concatenate(axes, axis=1), len(effects)
    place = (0.5 * (time[1:] + time[:-1])[joined] - time[0]) / max(time[-1] - time[0], 1e-12)
    return Rows(rows[0], rows[1 : 1 + k].T, rows[1 + k :].T), np.tile(place, len(axes))


def sums(chain: Chain, record: Record, options: Sequence[Option], drift: bool = True) -> Sums:
    """Sums of a record's rows over its blocks."""
    rows, place = rows_of(chain, record, options, drift)
    return sums_of(rows, place)


def why_not(chain: Chain, record: Record) -> str | None:
    """Why a record cannot be compared, as a sentence; None where it can."""
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


def _track_noise(path: Any) -> tuple[float, float]:
    place = max(sensor_sd(path.north), sensor_sd(path.east))
    speed = float(np.mean(np.hypot(path.surge, path.sway)))
    walk = np.hypot(max(sensor_sd(path.surge), sensor_sd(path.sway)), speed * sensor_sd(path.heading))
    return place, float(walk * np.sqrt(path.step_s))


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
