"""Errors of predicted held-out records.

Free run: `estimation/run/run.py`, as every command has it.  One step: every sample is predicted from the one before.
Both are compared with the record's own samples and pooled over all held-out records;
heading is unwrapped.  Units are those of the channels.
"""

from __future__ import annotations

from ...estimation.run.run import CHANNELS
from .base import Outcome, score

COLUMNS = [
    f"{name}_{horizon}_{channel}" for horizon in ("free", "one") for name in ("rmse", "r2") for channel in CHANNELS
]


@score(dict.fromkeys(COLUMNS, "float"), rank=2)
def prediction_error(outcome: Outcome) -> dict[str, float]:
    """RMSE and R^2 by horizon and channel."""
    return {name: outcome.prediction[name] for name in COLUMNS if name in outcome.prediction}
