"""Times (N,) s that rise but cannot be those of one run: other units, clocks that were set while they were logged."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ..models.errors import BadInput

FARTHEST_S = 1e11
"""Time from zero that no clock in seconds shows, 3000 years: since 1970 in milliseconds it is so."""
LONGEST_GAP_S = 86400.0
"""Gap behind which another run begins."""
SHORTEST_STEP_S, LONGEST_STEP_S = 1e-4, 60.0
"""Steps of a log that can show a manoeuvre."""
MOST_SAMPLES = 20_000_000
"""Samples of a record; a file of the largest size that is read has about ten million."""


class TimeFault(NamedTuple):
    """index : of the sample that it shows at;  message, hint : what is wrong, and what to do."""

    index: int
    message: str
    hint: str


def time_fault(time: np.ndarray) -> TimeFault | None:
    """What is wrong with finite times that rise; None where they can be those of one run."""
    if time.size < 2:
        return None
    far = max(-time[0], time[-1])
    if far > FARTHEST_S:
        index = 0 if time[-1] < far else time.size - 1
        hint = "milliseconds in time_s? then call the column time_ms; else count seconds from the start of the run"
        return TimeFault(index, f"a time of {time[index]:.6g} s", hint)
    steps = np.diff(time)
    if steps.max() > LONGEST_GAP_S and not steps.min() > LONGEST_STEP_S:
        index = int(steps.argmax()) + 1
        jump = f"{steps[index - 1] / 86400.0:.6g} days, from {time[index - 1]:.9g} to {time[index]:.9g} s"
        hint = "was the clock set, or are day and month exchanged? correct the times, or cut the file there"
        return TimeFault(index, f"time jumps by {jump}", hint)
    mean = (time[-1] - time[0]) / (time.size - 1)
    if SHORTEST_STEP_S <= mean <= LONGEST_STEP_S:  # then the median, which takes longer, cannot be wrong
        return None
    step = float(np.median(steps))
    if step > LONGEST_STEP_S:
        hint = "milliseconds in time_s? then call the column time_ms, or state the unit"
        return TimeFault(1, f"steps of {step:.6g} s, in which no manoeuvre shows", hint)
    if step < SHORTEST_STEP_S:
        hint = "are these seconds? write the times in seconds with all their digits"
        return TimeFault(1, f"steps of {step:.3g} s, shorter than those of any log", hint)
    return None


def refuse_time_fault(time: np.ndarray, record: object) -> None:
    """BadInput where `time_fault` finds something wrong with the times of a record."""
    wrong = time_fault(time)
    if wrong is not None:
        raise BadInput(f"{wrong.message} (sample {wrong.index})", file=record, column="time_s", hint=wrong.hint)
