"""Motion of held-out records: what is handed out, what a model predicts, and errors."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np

from ...datasets.record import Record
from ...diagnosis.innovations.as_model import FIRST_PART
from ...estimation.validation.validate import TOGETHER, validate
from ...models.errors import BadInput
from ...models.model import Model
from ..kinds.diagnosis.columns import CHANNELS
from ..kinds.diagnosis.judge import wrapped

Motion = Mapping[str, np.ndarray]
"""Channel -> values (N,) at the times of a record, SI."""
SCORED = TOGETHER
"""Channels whose errors count; positions sum up all errors and do not."""
DIGITS = 7
"""Significant digits of the numbers of an exam."""
UNUSABLE = 1e6
"""Error where a model predicts nothing."""


def rounded(values: np.ndarray) -> np.ndarray:
    """Values (N,) to `DIGITS` significant digits, nan as it is."""
    return np.array([float(f"{x:.{DIGITS}g}") for x in values.tolist()])


def logged(record: Record) -> Record:
    """A record whose channels have so many digits."""
    return replace(record, channels={name: rounded(values) for name, values in record.channels.items()})


def opening(record: Record) -> int:
    """Number of samples at the beginning of a held-out record whose motion is handed out.

    From it state, wind and current of the record can be estimated, as `diagnose` does.
    """
    return int(np.searchsorted(record.time_s, FIRST_PART * record.time_s[-1])) + 1


def without_motion(record: Record) -> Record:
    """A held-out record as it is handed out: its motion ends with the opening, its rudder goes on."""
    shown = np.arange(record.n) < opening(record)
    blank = {c: np.where(shown, x, np.nan) if c in CHANNELS else x for c, x in record.channels.items()}
    return replace(record, channels=blank)


def predicted(model: Model, records: Sequence[Record]) -> dict[str, Motion]:
    """Name of a record -> free run of a model along it, as `helmbench validate` computes it.

    It starts from the recorded state at the beginning.  Raises BadInput where no record suits the model.
    """
    found = validate({model.id: model}, {record.name: record for record in records}, ahead=False)
    return {run.record: run.predicted for run in found.runs}


def predicted_or_none(model: Model, records: Sequence[Record]) -> dict[str, Motion]:
    """As `predicted`; empty where no record suits the model."""
    try:
        return predicted(model, records)
    except BadInput:
        return {}


def errors(measured: Mapping[str, Motion], runs: Mapping[str, Motion], starts: Mapping[str, int]) -> dict[str, float]:
    """Root mean square error of each scored channel over the samples behind the opening of all records.

    measured, runs : name of a record -> motion; starts : first sample that counts.  A channel is left out where a run
    does not have it in every record.
    """
    channels = [c for c in SCORED if all(c in m and c in runs.get(name, {}) for name, m in measured.items())]
    found = {}
    for c in channels:
        parts = [error(m[c], runs[name][c], c)[starts[name] :] for name, m in measured.items()]
        found[c] = float(np.sqrt(np.nanmean(np.concatenate(parts) ** 2)))
    return found


def error(measured: np.ndarray, run: np.ndarray, channel: str) -> np.ndarray:
    """Errors (N,) of a run, headings by the smaller angle, nan where nothing was measured."""
    found = measured - run
    found = wrapped(found) if channel == "heading_rad" else found
    return np.where(np.isnan(measured) | np.isfinite(run), found, UNUSABLE)
