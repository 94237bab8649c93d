"""Streams of several loggers on one time base: clocks are aligned, samples averaged or interpolated."""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from ..geometry import unwrapped
from ..signals import integral
from ..time_faults import MOST_SAMPLES, time_fault
from .clocks import align
from .convert import Stream
from .draft import Question
from .quantities import quantities
from .result import FileFault

SLOW_MATTERS = frozenset({"propeller", "propeller_thrust", "wind_speed", "wind_direction", "magnetic_variation"})
"""Quantities that change slowly: a logger of these alone does not set the time step."""
COLD, YEAR_S = 0.2, 365.25 * 86400.0
"""Share of samples that may lie before a clock was set, and the year by which the clock then jumps at least."""
OUTSIDE = 0.1
"""Share of a table's rows that may lie outside of the time of a record without a word."""
LONGEST_GAP = 3.0
"""Steps of a logger over which is interpolated; longer ones stay gaps."""


@dataclass(frozen=True)
class Merged:
    """Quantities (N,) over one time (N,) s; `steps` says what was done."""

    time: np.ndarray
    quantities: dict[str, np.ndarray]
    dated: bool
    steps: tuple[str, ...]
    streams: tuple[Stream, ...]


def merge(
    streams: Sequence[Stream], step_s: float | None = None
) -> tuple[Merged | None, list[FileFault], list[Question]]:
    """One run from streams of several loggers, or from a single one, faults, and questions for their clocks.

    A single stream keeps its samples unless `step_s` asks for another step.  Several are put on a grid with the step
    of the slowest of them, or with `step_s`: faster ones are averaged over a step, the others interpolated linearly,
    not over gaps of more than three of their steps.
    """
    faults: list[FileFault] = []
    sorted_out = []
    for stream in streams:
        jumps = np.flatnonzero(np.diff(stream.time) > YEAR_S)
        first = int(jumps[0]) + 1 if jumps.size else 0
        if stream.dated and 0 < first <= COLD * stream.time.size:  # before a clock was set by its first fix
            years = (stream.time[first] - stream.time[first - 1]) / YEAR_S
            told = f"{stream.label}: {first} samples before its clock was set, {years:.3g} years earlier, left out"
            stream = replace(stream.at(slice(first, None)), done=(*stream.done, told))
        sorted_out.append(stream)
    for stream in sorted_out:
        wrong = time_fault(stream.time if not stream.dated else stream.time - stream.time[0])
        if wrong is not None:
            hint = f"{wrong.hint}; --map can state the form"
            faults.append(FileFault(stream.label, wrong.message, hint, fatal=True))
    if faults:
        return None, faults, []
    aligned, done, faults, asked = align(sorted_out)
    if asked:
        return None, faults, asked
    done = [*itertools.chain(*(stream.done for stream in aligned)), *done]
    dated = any(stream.dated for stream in aligned)
    same = all(np.array_equal(stream.time, aligned[0].time) for stream in aligned)
    if same and step_s is None:
        return Merged(aligned[0].time, _together(aligned), dated, tuple(done), tuple(aligned)), faults, []
    leading = [stream for stream in aligned if not set(stream.quantities) <= SLOW_MATTERS] or aligned
    step = step_s or float(f"{max(stream.step for stream in leading):.4g}")
    start, stop = max(stream.time[0] for stream in leading), min(stream.time[-1] for stream in leading)
    count = max(0.0, (stop - start) / step + 1e-6) + 1.0
    if count > MOST_SAMPLES:
        said = f"a step of {step:.3g} s gives {count:.3g} samples"
        return None, [*faults, FileFault(aligned[0].label, said, "give a longer --step", fatal=True)], []
    grid = start + step * np.arange(int(count))
    if grid.size < 3:
        extents = (f"{stream.label} {stream.time[0]:.3f} to {stream.time[-1]:.3f} s" for stream in aligned)
        said = f"the loggers have no time in common: {', '.join(extents)}"
        hint = "give the files of one run, or clock_offset_s in the mapping"
        return None, [*faults, FileFault(aligned[0].label, said, hint, fatal=True)], []
    placed = []
    for stream in aligned:
        count = int(np.sum((stream.time < grid[0] - stream.step) | (stream.time > grid[-1] + stream.step)))
        if count > OUTSIDE * stream.time.size:
            said = f"{count} of {stream.time.size} rows lie outside of the {np.ptp(grid):.4g} s that all tables cover"
            faults.append(FileFault(stream.label, said, "left out; import the file alone to keep them"))
        values, told = _resampled(stream, grid, step)
        placed.append(replace(stream, time=grid, quantities=values))
        done.append(told)
    return Merged(grid, _together(placed), dated, tuple(done), tuple(aligned)), faults, []


def _together(streams: Sequence[Stream]) -> dict[str, np.ndarray]:
    """All quantities; of one that several have, that of the stream that has it with the fewest gaps."""
    out: dict[str, np.ndarray] = {}
    for stream in streams:
        for name, values in stream.quantities.items():
            if name not in out or np.isfinite(values).sum() > np.isfinite(out[name]).sum():
                out[name] = values
    return out


def _resampled(stream: Stream, grid: np.ndarray, step: float) -> tuple[dict[str, np.ndarray], str]:
    """The quantities on the grid, and how."""
    if np.array_equal(stream.time, grid):
        return dict(stream.quantities), f"{stream.label}: {stream.time.size} samples every {step:.4g} s, kept"
    averaged = stream.step < 0.75 * step
    how = "averaged" if averaged else "interpolated linearly"
    told = f"{stream.label}: {stream.time.size} samples every {stream.step:.4g} s, {how} to every {step:.4g} s"
    values = {}
    for name, series in stream.quantities.items():
        series = unwrapped(series) if quantities()[name].wraps else series
        known = np.isfinite(series)
        place = _averaged if averaged else _interpolated
        values[name] = place(stream.time[known], series[known], grid, step, stream.step)
    return values, told


def _averaged(time: np.ndarray, values: np.ndarray, grid: np.ndarray, step: float, own: float) -> np.ndarray:
    """Means (M,) of the line through the samples over half a step to both sides; nan beside gaps of three steps.

    At the ends of the samples the means are over as much as is known on both sides.
    """
    if time.size < 2:
        return np.full(grid.size, np.nan)
    whole = integral(values, time)
    half = np.clip(np.minimum(grid - time[0], time[-1] - grid), -1.0, step / 2.0)
    half = np.where(np.abs(half) < 1e-3 * step, 1e-3 * step, half)
    low, high = grid - half, grid + half
    with np.errstate(invalid="ignore", divide="ignore"):
        mean = (_integral_at(high, time, values, whole) - _integral_at(low, time, values, whole)) / (high - low)
    wide = np.concatenate([[0], np.cumsum(np.diff(time) > LONGEST_GAP * own)])
    first, last = (np.clip(np.searchsorted(time, edge), 0, time.size - 1) for edge in (low, high))
    return np.where((high > low) & (wide[first] == wide[last]), mean, np.nan)


def _integral_at(at: np.ndarray, time: np.ndarray, values: np.ndarray, whole: np.ndarray) -> np.ndarray:
    """Integral (M,) up to some times of the line through samples (N,), whose integral up to each of them is known."""
    place = np.clip(np.searchsorted(time, at, side="right") - 1, 0, time.size - 2)
    since = at - time[place]
    slope = (values[place + 1] - values[place]) / (time[place + 1] - time[place])
    return whole[place] + since * (values[place] + 0.5 * slope * since)


def _interpolated(time: np.ndarray, values: np.ndarray, grid: np.ndarray, step: float, own: float) -> np.ndarray:
    """Linear interpolation (M,); nan outside and in gaps of more than three steps."""
    if time.size < 2:
        return np.full(grid.size, np.nan)
    out = np.interp(grid, time, values, left=np.nan, right=np.nan)
    after = np.clip(np.searchsorted(time, grid), 1, time.size - 1)
    gap = (time[after] - time[after - 1]) > LONGEST_GAP * own
    on_sample = np.abs(time[after] - grid) < 1e-9
    return np.where(gap & ~on_sample, np.nan, out)
