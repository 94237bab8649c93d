"""Runs of equal samples: frozen channels, channels that change more slowly than the rows, coarse steps."""

from __future__ import annotations

from collections.abc import Iterable
from typing import NamedTuple

import numpy as np

SHORTEST = 5
"""Equal samples in a row from which a channel may be frozen."""
RARE = 1e-4
JUMP = 0.25
"""Share of the channel's usual step by which it must jump before or after a frozen stretch."""
TURNS = 0.4
"""Share of steps in the other direction than the one before from which a channel is noisy."""
NEIGHBOURS = 60
"""Samples to each side of a stretch whose steps are compared with it, at least."""
STEADY = 0.25
"""Share of the yaw rate's root mean square from which it turns the ship."""
COARSE = 3.5
"""Steps of a coarse channel by which it must jump after a frozen stretch."""
ROUNDING = 1e-12
"""Share of a channel's largest value, and least size in SI units, below which differences are rounding of numbers."""


class Run(NamedTuple):
    """Samples start .. stop - 1 of a channel are equal; jump: step out of them over the usual step beside them."""

    start: int
    stop: int
    jump: float = 0.0


def rounding(values: np.ndarray) -> float:
    """Difference of two samples (N,) up to which they are the same number, rounded."""
    return ROUNDING * float(np.max(np.abs(values[np.isfinite(values)]), initial=1.0))


def never_changes(values: np.ndarray) -> bool:
    """Whether no two known samples (N,) differ by more than rounding."""
    known = values[np.isfinite(values)]
    return known.size < 2 or float(np.ptp(known)) <= rounding(known)


def runs_of(values: np.ndarray) -> list[Run]:
    """Maximal runs of at least two equal finite samples (N,)."""
    same = np.concatenate([[False], values[1:] == values[:-1], [False]])
    edge = np.flatnonzero(np.diff(same.astype(int)))
    return [Run(int(a), int(b) + 1) for a, b in zip(edge[0::2], edge[1::2], strict=True)]


def frozen_runs(values: np.ndarray) -> list[Run]:
    """Runs that are too long for the channel: its steps near by make them improbable, and it jumps out of them.

    A motion that comes to rest and leaves it smoothly is not frozen, nor is a coarse channel that moves slowly. A noisy
    channel need not jump: its noise does not come to rest.
    """
    known = values[np.isfinite(values)]
    if known.size < 4 * SHORTEST or never_changes(known):
        return []
    long = [r for r in runs_of(values) if r.stop - r.start >= SHORTEST]
    return [r._replace(jump=jump) for r in long if (jump := _jump_if_frozen(values, r, known.size)) > 0.0]


def stuck_runs(rate: np.ndarray) -> list[Run]:
    """Runs of a yaw rate (N,) that are too long for it at a value that turns the ship: whether it jumps out of them or
    not, no ship turns so steadily."""
    known = rate[np.isfinite(rate)]
    turning = STEADY * float(np.sqrt(np.mean(known**2))) if known.size else 0.0
    long = (r for r in runs_of(rate) if r.stop - r.start >= SHORTEST and abs(rate[r.start]) > turning)
    return [r for r in long if _is_rare(_steps(_beside(rate, r)), r, known.size)]


def _beside(values: np.ndarray, run: Run) -> tuple[np.ndarray, np.ndarray]:
    """Samples before a run, and after it, with those of its ends."""
    reach = max(NEIGHBOURS, 3 * (run.stop - run.start))
    return values[max(run.start - reach, 0) : run.start + 1], values[run.stop - 1 : run.stop + reach]


def _steps(sides: Iterable[np.ndarray]) -> np.ndarray:
    """Sizes of the known steps within stretches of samples."""
    steps = np.abs(np.concatenate([np.diff(side) for side in sides]))
    return steps[np.isfinite(steps)]


def _is_rare(steps: np.ndarray, run: Run, samples: int) -> bool:
    """Whether the steps beside a run make it improbable among so many samples."""
    return samples * _share_at_rest(steps) ** (run.stop - run.start - 1) < RARE


def _share_at_rest(steps: np.ndarray) -> float:
    """Share of steps in which a channel does not change, at least 1e-3."""
    return max(float(np.mean(steps == 0.0)), 1e-3) if steps.size else 1.0


def _jump_if_frozen(values: np.ndarray, run: Run, samples: int) -> float:
    """Jump out of a run in usual steps beside it, where these make the run improbable; else 0."""
    before, after = _beside(values, run)
    steps = _steps((before, after))
    moving = steps[steps > 0.0]
    if moving.size < SHORTEST:
        return 0.0
    jump = _jump(values, run) / float(np.median(moving))
    sides = [side for side in (before, after) if np.isfinite(side).sum() > SHORTEST + 1]  # none at the record's ends
    least = COARSE if _share_at_rest(steps) > 0.1 else 0.0 if sides and all(map(_noisy, sides)) else JUMP
    return jump if jump > least and _is_rare(steps, run, samples) else 0.0


def _noisy(values: np.ndarray) -> bool:
    """Whether steps turn back so often as those of noise: two of three for white noise."""
    turns = np.diff(np.sign(np.diff(values[np.isfinite(values)]))) != 0.0
    return turns.size >= SHORTEST and float(np.mean(turns)) > TURNS


def _jump(values: np.ndarray, run: Run) -> float:
    """Larger of the steps into and out of a run; 0 at the record's ends and beside gaps.

    A step counts as far as the second sample beyond the run confirms it: one gross error beside a run is none.
    """
    sides = (values[max(run.start - 2, 0) : run.start], values[run.stop : run.stop + 2])
    known = [side for side in sides if side.size and np.isfinite(side).all()]
    return max((float(np.min(np.abs(side - values[run.start]))) for side in known), default=0.0)


def held_rows(values: np.ndarray) -> int:
    """Rows after which a channel usually changes: 1, or more where most of its samples repeat regularly."""
    known = values[np.isfinite(values)]
    changes = np.flatnonzero(np.diff(known) != 0.0)
    if changes.size < 20:
        return 1
    between = np.diff(changes)
    usual = int(np.median(between))
    return usual if usual > 1 and np.mean(between % usual == 0) > 0.7 else 1


def resolution(values: np.ndarray) -> float:
    """Step of which all samples (N,) are multiples, where they take few values; 0 for a finely resolved channel."""
    known = _distinct(values)
    return 0.0 if known.size > 0.25 * np.isfinite(values).sum() else _step(known)


def common_step(values: np.ndarray) -> float:
    """Step of which all samples (N,) are multiples; 0 where there is none."""
    return _step(_distinct(values))


def _distinct(values: np.ndarray) -> np.ndarray:
    """Different values in order; those that differ by rounding are one, and none of a channel that never changes."""
    known = np.unique(values[np.isfinite(values)])
    if never_changes(known):
        return known[:0]
    return known[np.diff(known, prepend=-np.inf) > max(rounding(known), 1e-9 * float(np.ptp(known)))]


def _step(known: np.ndarray) -> float:
    if known.size < 3:
        return 0.0
    steps = np.diff(known)
    q = float(np.min(steps))
    off = np.abs(steps / q - np.round(steps / q))
    return q if np.mean(off < 0.02) > 0.98 else 0.0
