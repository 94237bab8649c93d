"""Records as the filter takes them: cut at long gaps into segments, on its six channels, gross errors removed."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from ....datasets.instruments import quietened, rudder_noise
from ....datasets.record import Record
from ....datasets.signals import bridged
from ....datasets.spikes import without_spikes_in_time
from ....models.errors import CannotFit
from ....models.kernels import Kernels
from ....models.model import Model
from ...records.gaps import SHORTEST, parts_of
from ...records.series import initial_state_of, inputs_of, samples
from ...records.weather import held_weather
from .vector import CHANNELS, SYMBOLS, state_of

FEWEST, RARE = 20, 0.2
"""Values below which a channel's noise cannot be estimated, where that is also less than a share RARE of the values of
the channel that is measured most: such a channel is left out."""


@dataclass(frozen=True)
class Segment:
    """One stretch of a record without a long gap.

    record : index of the record that it belongs to.  offset_s : time of its first sample in the record, s.
    time (T,) from zero, rudder (T,), quiet (T,) the rudder without its sensor's noise, other (T, no) further inputs,
    environment (T, 4) recorded current and wind (m/s, north and east, towards), measured (T, 6) with nan gaps; start,
    variance (n,) of the first state.
    """

    name: str
    record: int
    offset_s: float
    time: np.ndarray
    rudder: np.ndarray
    quiet: np.ndarray
    other: np.ndarray
    environment: np.ndarray
    measured: np.ndarray
    start: np.ndarray
    variance: np.ndarray

    @property
    def step_s(self) -> float:
        """Median sampling step."""
        return float(np.median(np.diff(self.time)))

    def first(self, count: int) -> Segment:
        """The same with its first samples only."""
        series = ("time", "rudder", "quiet", "other", "environment", "measured")
        return replace(self, **{name: getattr(self, name)[:count] for name in series})


def segments_of(records: Sequence[Record], model: Model, kernels: Kernels, clock: float) -> tuple[Segment, ...]:
    """All segments of the records in turn.

    clock : time scale against a 160 m ship.

    Raises
    ------
    CannotFit : a record lacks an input, has no rudder, neither heading nor yaw rate, or no segment that is long enough.
    """
    found: list[Segment] = []
    for index, record in enumerate(records):
        if not np.isfinite(inputs_of(record, model)["delta"]).any():
            raise CannotFit(f"record {record.name} has no rudder samples")
        if not any((values := samples(record, s)) is not None and np.isfinite(values).any() for s in ("psi", "r")):
            raise CannotFit(f"record {record.name} has neither heading nor yaw rate")
        parts = parts_of(record, clock)
        own = [s for part in parts if (s := _segment(part, record, index, model, kernels)) is not None]
        if not own:
            raise CannotFit(f"record {record.name}: no {SHORTEST} samples in turn have rudder and heading or yaw rate")
        found += own
    noise, used = rudder_sd(found), ~_hardly_measured(found)
    if not used.all():
        found = [replace(d, measured=np.where(used, d.measured, np.nan)) for d in found]
    return tuple(replace(d, quiet=quietened(d.rudder, noise)) for d in found)


def _hardly_measured(segments: Sequence[Segment]) -> np.ndarray:
    """(6,) whether a channel has too few values for its sensor's noise to be estimated, and another has many."""
    counts = np.sum([np.isfinite(d.measured).sum(axis=0) for d in segments], axis=0)
    return (counts < FEWEST) & (counts < RARE * counts.max())


def rudder_sd(segments: Sequence[Segment]) -> float:
    """Noise (sd) of the rudder's sensor, rad: the least of all segments."""
    return max(min(rudder_noise(d.rudder) for d in segments), 1e-7)


def _segment(part: Record, record: Record, index: int, model: Model, kernels: Kernels) -> Segment | None:
    """A stretch of a record; None where it has neither heading nor yaw rate."""
    measured = np.full((part.n, CHANNELS), np.nan)
    for c, symbol in enumerate(SYMBOLS):
        values = samples(part, symbol)
        if values is not None and state_of(symbol, kernels.STATES) is not None:
            measured[:, c], _, _ = without_spikes_in_time(values, part.time_s)
    if not np.isfinite(measured[:, :2]).any():
        return None
    given = inputs_of(part, model)
    time = np.ascontiguousarray(part.time_s - part.time_s[0])
    rudder = np.ascontiguousarray(bridged(given["delta"], time))
    other = [bridged(given[name], time) for name in model.inputs[1:]]
    start, spread = _start(part, model, kernels, rudder[0])
    return Segment(
        name=record.name,
        record=index,
        offset_s=float(part.time_s[0] - record.time_s[0]),
        time=time,
        rudder=rudder,
        quiet=rudder,
        other=np.ascontiguousarray(np.column_stack([*other, np.zeros((time.size, 0))])),
        environment=held_weather(record, model, part.time_s),
        measured=measured,
        start=start,
        variance=spread**2,
    )


def _start(record: Record, model: Model, kernels: Kernels, rudder: float) -> tuple[np.ndarray, np.ndarray]:
    """First state of the model's bank variant and its standard deviations."""
    start, spread = initial_state_of(record, model)
    for i, name in enumerate(model.states):
        if name == "w" and kernels.RATE_GAIN is not None:
            start[i] -= model.coefficients[kernels.RATE_GAIN] * rudder
    extra = [rudder if name == "lead_state" else 0.0 for name in kernels.STATES[len(model.states) :]]
    return np.concatenate([start, extra]), np.concatenate([spread, np.zeros(len(extra))])
