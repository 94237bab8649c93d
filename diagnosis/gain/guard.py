"""How much worse than the base model an extended model may predict what it was not fitted to, and falls of errors."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING

import numpy as np

from ...datasets.columns import POSITIONS, TURN
from ..causes.steering_gear import own_neutral_angles
from ..free_runs.units import FLOOR

if TYPE_CHECKING:
    from ..result import Diagnosis

CLEARLY = 0.1
"""Mean of the logarithms of two errors' ratio from which one is clearly larger."""
MUCH_WORSE = 1.5
"""Ratio of the errors of held-out records with each record's own trim to the base model's, in any channel, from which a
cause is given up where they are no smaller without it."""
SMALL = 0.1
"""Error of held-out records, as a share of the motion, that is small where others fall."""
WORSE = 1.05
"""Ratio of the free-run errors (rms) of left-out records to the base model's, in any channel, from which a cause or a
group of numbers is given up."""


def log_fall(before: Mapping[str, float], after: Mapping[str, float]) -> float:
    """By how much the logarithm of the error falls, in the mean over channels that have a positive error in both; 0
    where there is none."""
    shared = [c for c, error in after.items() if error > 0.0 and before.get(c, 0.0) > 0.0]
    return float(np.mean([np.log(before[c] / after[c]) for c in shared])) if shared else 0.0


def training_errors(diagnosis: Diagnosis) -> dict[str, tuple[float, float]]:
    """Channel -> root mean square errors of free runs of the training records by the base and the extended model."""
    parts: dict[str, list[np.ndarray]] = {}
    for trace in (t for t in diagnosis.traces if t.role == "train"):
        for channel, measured in trace.measured.items():
            both = measured - np.stack([trace.before[channel], trace.after[channel]])
            parts.setdefault(channel, []).append(both[:, np.isfinite(both).all(axis=0)])
    whole = {c: np.concatenate(blocks, axis=1) for c, blocks in parts.items()}
    rms = {c: np.sqrt(np.mean(e**2, axis=1)).tolist() for c, e in whole.items() if e.size}
    return {c: (before, after) for c, (before, after) in rms.items()}


def worsens(said: Diagnosis, outweighed: bool = False) -> bool:
    """Whether some channel of the held-out records is predicted worse, also with each record's own trim, or much worse
    with it and no better without; or the motion of these or of whole training records clearly worse without it, in the
    mean over channels.

    Where each record has a neutral angle of its own, which a further one does not tell, only errors with it count,
    unless those without are much larger than the base model's: then other numbers hold the opposite of it.
    Positions are one distance, beyond what counts as none: how their axes are turned is arbitrary, and they sum up what
    the speed and the heading show.

    Where the motion is predicted clearly better in that mean, with trim and without, a channel that is predicted within
    SMALL of its motion is not worse.

    outweighed : there, any channel is worse only where it is much worse.
    """
    own, blind, training = _trimmed_errors(said), _blind_errors(said), training_errors(said)
    if own_neutral_angles(said.causes):
        if _motion_fall(blind) < -np.log(MUCH_WORSE):
            return True
        blind, training = own, {}
    if any(_motion_fall(errors) < -CLEARLY for errors in (blind, training)):
        return True
    better = min(map(_motion_fall, (blind, own))) > CLEARLY
    least = MUCH_WORSE if outweighed and better else WORSE
    near = {c for c, g in said.gain.items() if better and g.r2_after > 1.0 - SMALL**2}
    pairs = [(least, blind[c], own[c]) for c in said.gain if c not in (*POSITIONS, *near)]
    places = [c for c in said.gain if c in POSITIONS]
    if places:
        pairs.append((WORSE, _distances(blind, places), _distances(own, places, _place_floor(said))))
    return any(
        all(after > ratio * before for before, after in (plain, trimmed))
        or (trimmed[1] > MUCH_WORSE * trimmed[0] and plain[1] > plain[0] / WORSE)
        for ratio, plain, trimmed in pairs
    )


def _distances(
    errors: Mapping[str, tuple[float, float]], places: Sequence[str], least: float = 0.0
) -> tuple[float, float]:
    """Errors of positions before and after as one distance, m, no smaller than the least."""
    before, after = (max(float(np.hypot.reduce([errors[c][i] for c in places])), least) for i in (0, 1))
    return before, after


def _place_floor(said: Diagnosis) -> float:
    """Error of the position, m, that counts as none: that of a speed which does, over the way of the held-out runs."""
    runs = [[t.measured[c] for c in POSITIONS if c in t.measured] for t in said.traces if t.role == "held_out"]
    known = [[track[np.isfinite(track)] for track in tracks] for tracks in runs]
    ways = [np.hypot.reduce([np.ptp(track) for track in tracks if track.size]) for tracks in known]
    return FLOOR["u"] * float(np.mean(ways)) if ways else 0.0


def blind_fall(said: Diagnosis) -> float:
    """Fall of the logarithm of the errors of held-out records without their own trim, in the mean over channels but
    positions."""
    return _motion_fall(_blind_errors(said))


def is_for_trim(said: Diagnosis) -> bool:
    """Whether held-out records are predicted better only where their own trim is not known, and no better with it: what
    is named stands for a neutral angle."""
    return blind_fall(said) > 0.0 > _motion_fall(_trimmed_errors(said))


def training_fall(said: Diagnosis) -> float:
    """Fall of the logarithm of the errors of whole training records, as that of held-out ones."""
    return _motion_fall(training_errors(said))


def misleads(said: Diagnosis) -> bool:
    """Whether the turning of held-out records is predicted clearly worse in some channel where their own trim is not
    known."""
    turning = (gain for channel, gain in said.gain.items() if channel in TURN)
    return any(gain.rmse_after > WORSE * gain.rmse_before for gain in turning)


def _blind_errors(said: Diagnosis) -> dict[str, tuple[float, float]]:
    """Channel -> errors of held-out records before and after, without their own trim."""
    return {c: (g.rmse_before, g.rmse_after) for c, g in said.gain.items()}


def _trimmed_errors(said: Diagnosis) -> dict[str, tuple[float, float]]:
    """Channel -> errors of held-out records before and after, with each record's own trim."""
    return {c: (g.own_before, g.own_after) for c, g in said.gain.items()}


def _motion_fall(errors: Mapping[str, tuple[float, float]]) -> float:
    """Fall of the logarithm of errors before and after, in the mean over channels but positions."""
    motion = {c: pair for c, pair in errors.items() if c not in POSITIONS}
    return log_fall(*({c: pair[i] for c, pair in motion.items()} for i in (0, 1)))
