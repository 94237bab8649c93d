"""How much worse than the base model an extended model may predict what it was not fitted to, and falls of errors."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING

import numpy as np

from ...datasets.columns import POSITIONS

if TYPE_CHECKING:
    from ..result import Diagnosis

CLEARLY = 0.1
"""Mean of the logarithms of two errors' ratio from which one is clearly larger."""
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


def worsens(said: Diagnosis) -> bool:
    """Whether some channel of the held-out records is predicted worse, also with each record's own trim (the positions
    together: how their axes are turned is arbitrary); or the motion of these or of whole training records clearly worse
    without it, in the mean over channels."""
    blind = {c: (g.rmse_before, g.rmse_after) for c, g in said.gain.items()}
    own = {c: (g.own_before, g.own_after) for c, g in said.gain.items()}
    if any(_motion_fall(errors) < -CLEARLY for errors in (blind, training_errors(said))):
        return True
    pairs = zip(_with_one_position(blind), _with_one_position(own), strict=True)
    return any(all(after > WORSE * before for before, after in pair) for pair in pairs)


def _with_one_position(errors: Mapping[str, tuple[float, float]]) -> list[tuple[float, float]]:
    """Errors before and after of channels, those of the positions as one distance."""
    places = [pair for c, pair in errors.items() if c in POSITIONS]
    before, after = (float(np.hypot.reduce([pair[i] for pair in places])) for i in (0, 1))
    return [*(pair for c, pair in errors.items() if c not in POSITIONS), *([(before, after)] if places else [])]


def _motion_fall(errors: Mapping[str, tuple[float, float]]) -> float:
    """Fall of the logarithm of errors before and after, in the mean over channels but positions."""
    motion = {c: pair for c, pair in errors.items() if c not in POSITIONS}
    return log_fall(*({c: pair[i] for c, pair in motion.items()} for i in (0, 1)))
