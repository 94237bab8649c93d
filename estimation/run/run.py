"""The free run of a model along a record, and its errors: the only place that they are computed in.

    e(t_k) = y(t_k) - h(x(t_k)),   dx/dt = f(x, input(t), theta),   x(t_0) smoothed from the record

Input are the record's rudder, revolutions, current and wind.  A run starts anew behind each long gap and each splice
(`records/gaps`).  Every measured sample of every stretch counts from the first one on, as it was recorded: predictions
are those that the model's instruments show.  Headings do not wrap: an error is that of the angle turned through.  A run
that has diverged stays where it was, and says so.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from ...datasets.columns import RUDDERS, TWIN
from ...datasets.instruments import observed
from .squares import Squares, pooled, squares
from .stretch import Stretch, stretches_of

if TYPE_CHECKING:
    from ...datasets.record import Record
    from ...models.model import Model
    from ..results.predictor import Predictor
    from .stretch import FreeRun

CHANNELS = ("heading_rad", "yaw_rate_rad_s", "surge_m_s", "sway_m_s", "north_m", "east_m")
"""Channels that are scored, in the order of the record header; heading is unwrapped."""


@dataclass(frozen=True)
class Measured:
    """The samples of a record that runs are compared with: times (N,), rudder (N,), channels, heading not wrapped."""

    name: str
    time_s: np.ndarray
    rudder: np.ndarray
    channels: Mapping[str, np.ndarray]


@dataclass(frozen=True)
class Run:
    """The free run of one model along one record.

    predicted : channel -> (N,) at the record's times, nan where there is no run;  places : the samples of each stretch,
    at whose start the run starts anew;  diverged : pairs of the start of a run and the time after it, s, at which the
    run diverged.
    """

    model: str
    measured: Measured
    predicted: Mapping[str, np.ndarray]
    places: tuple[slice, ...]
    diverged: tuple[tuple[float, float], ...]

    @property
    def record(self) -> str:
        """Name of the record."""
        return self.measured.name

    @property
    def starts_s(self) -> tuple[float, ...]:
        """Times at which the run starts, anew behind each long gap."""
        return tuple(float(self.measured.time_s[place][0]) for place in self.places)

    @property
    def told(self) -> str:
        """`diverged after 43 s`, or an empty text."""
        times = " and ".join(f"{after:.3g} s" for _, after in self.diverged)
        return f"diverged after {times}" if times else ""

    def pairs(self, channel: str) -> list[tuple[np.ndarray, np.ndarray]]:
        """Measured and predicted samples (K,) of each stretch; gaps of the measured ones are nan."""
        both = self.measured.channels[channel], self.predicted[channel]
        pairs = [(both[0][place], both[1][place]) for place in self.places]
        return [(seen[np.isfinite(run)], run[np.isfinite(run)]) for seen, run in pairs]

    def squares(self) -> dict[str, Squares]:
        """Channel -> sums of squared errors over all stretches, each about its own mean."""
        return {channel: pooled(squares(*pair) for pair in self.pairs(channel)) for channel in self.predicted}


def run_along(
    model: Model,
    record: Record,
    predictor: Predictor | None = None,
    by: Callable[[Stretch], FreeRun] = Stretch.free_run,
) -> Run:
    """The free run of a model, or of a black box in its place, along a record as it was read.

    by : what makes the run of a stretch.

    Raises
    ------
    CannotFit : the record lacks an input, measures no state of the model, or has no stretch without long gaps.
    """
    turned = record.turned(model.positive_rudder)
    return run_of(stretches_of(model, turned, predictor), turned, model.id, record.name, by)


def run_of(
    stretches: Sequence[Stretch],
    record: Record,
    model: str,
    name: str,
    by: Callable[[Stretch], FreeRun] = Stretch.free_run,
) -> Run:
    """The run along the stretches of a record in the model's rudder sign; model, name : what it calls these."""
    measured = measured_of(name, record)
    predicted: dict[str, np.ndarray] = {}
    diverged = []
    for stretch in stretches:
        free = by(stretch)
        diverged += [] if free.diverged_s is None else [(float(stretch.record.time_s[0]), free.diverged_s)]
        piece = record.slice(stretch.place.start, stretch.place.stop)
        shown = as_shown(stretch.model, piece, stretch.channels(stretch.series.observe(free.states)))
        for channel in (c for c in measured.channels if shown.has(c)):
            values, seen = shown.column(channel), measured.channels[channel][stretch.place]
            values = values + (_whole_turns(seen - values) if channel == "heading_rad" else 0.0)
            predicted.setdefault(channel, np.full(record.n, np.nan))[stretch.place] = values
    return Run(model, measured, predicted, tuple(s.place for s in stretches), tuple(diverged))


def squares_of(runs: Sequence[Run]) -> dict[str, Squares]:
    """Channel, in the order of CHANNELS -> sums of squared errors over runs along several records."""
    each = [run.squares() for run in runs]
    return {c: pooled(own[c] for own in each if c in own) for c in CHANNELS if any(c in own for own in each)}


def measured_of(name: str, record: Record) -> Measured:
    """The channels of a record that have a sample."""
    channels = {c: record.continuous(c) for c in CHANNELS if record.has(c) and np.isfinite(record.column(c)).any()}
    return Measured(name, record.time_s, record.rudder(), channels)


def simulated_record(model: Model, record: Record, predictor: Predictor | None = None) -> Record:
    """A record of the free run: the inputs in the model's rudder sign and each channel (N,) that both have.

    Raises CannotFit as `run_along`.
    """
    run, turned = run_along(model, record, predictor), record.turned(model.positive_rudder)
    return replace(turned, channels={**_inputs(turned), **run.predicted})


def _inputs(record: Record) -> dict[str, np.ndarray]:
    return {name: record.column(name) for name in (*RUDDERS, "propeller_rps", *TWIN) if record.has(name)}


def as_shown(model: Model, record: Record, runs: Mapping[str, np.ndarray]) -> Record:
    """Predicted channels (N,) of the hull as the model's instruments show them, beside the inputs of the record.

    The record has the model's rudder sign.  Predictions are nan where they are not finite.
    """
    channels = {name: np.where(np.isfinite(values), values, np.nan) for name, values in runs.items()}
    return observed(replace(record, channels={**_inputs(record), **channels}), model.instruments)


def _whole_turns(gap: np.ndarray) -> float:
    """The whole turns, rad, that are nearest to the first known gap (N,) between two headings."""
    known = gap[np.isfinite(gap)]
    return float(2.0 * np.pi * np.round(known[0] / (2.0 * np.pi))) if known.size else 0.0
