"""What the extended model gains on held-out records; causes that predict worse are left out of it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from ...estimation.filters.innovations.estimator import estimator
from ...estimation.filters.innovations.vector import SENSORS
from ..selection.forward import without
from ..state import State, Unmodelled
from . import free_runs

if TYPE_CHECKING:
    from ...datasets.record import Record
    from ...estimation.filters.innovations.settings import Parameter, Setting
    from ..causes.base import Cause
    from ..options import Options
    from ..result import Gain, Trace

JUDGED, WORSE = ("heading_rad", "yaw_rate_rad_s"), 1.2
"""Channels by which the extended model is judged, and the ratio of its errors to the base model's that is too much."""


@dataclass(frozen=True)
class Predicted:
    """The state without the causes that predict worse, the setting that it is simulated at, the gain by channel, the
    traces that a page shows, and the causes that were left out."""

    state: State
    setting: Setting
    gain: dict[str, Gain]
    traces: tuple[Trace, ...]
    failing: tuple[Cause, ...]


def predicting(state: State, records: Sequence[Record], options: Options, rng: np.random.Generator) -> Predicted:
    """Leave out the last causes as long as they make free runs of held-out records worse than the base model's."""
    failing: list[Cause] = []
    while True:
        setting = _simulating(state, options)
        gain, traces = gain_of(state, setting, records, options, rng)
        ratios = [gain[c].rmse_after / gain[c].rmse_before for c in JUDGED if c in gain]
        bad = bool(ratios) and not any(ratio <= WORSE for ratio in ratios)
        if not bad or not state.accepted or not state.accepted[-1].variant:
            return Predicted(state, setting, gain, traces, tuple(failing))
        last = state.accepted[-1].cause
        failing += [] if isinstance(last, Unmodelled) else [last]
        state = without(state, state.accepted[-1])


def _simulating(state: State, options: Options) -> Setting:
    """The setting that the extended model is simulated at: free coefficients are fitted to free runs."""
    if options.base_parameters != "identify":
        return state.setting
    numbers = (f"{name}_{kind}" for name in SENSORS for kind in ("scale", "bias", "delay"))
    sensors = {state.est.index[name] for name in (*numbers, "axis_misalignment", "reference_speed")}
    moved = [p for p in state.parameters if not {entry for entry, _ in p.slots} & sensors]
    return free_runs.fitted_to_simulate(state.est, state.setting, moved)


def gain_of(
    state: State, final: Setting, records: Sequence[Record], options: Options, rng: np.random.Generator
) -> tuple[dict[str, Gain], tuple[Trace, ...]]:
    """Gain on the held-out records, and the traces that the page shows."""
    est, base = state.est, _base_setting(state, options)
    fitted = [free_runs.free_runs(est, s) for s in (base, final)]
    shown = free_runs.traces(est, "train", fitted[0], fitted[1], free_runs.scored_from(est, False))
    if not records:
        return {}, shown
    held = replace(
        estimator(est.model, records, est.unit, est.threads, est.terms), rudder_sd=est.rudder_sd, base=est.base
    )
    of_record = [p for a in state.accepted for p in a.variant if p.record is not None]
    steady = _steady(state)
    after = free_runs.transferred(held, final, of_record)
    after = free_runs.adapted(held, after, steady)
    before = free_runs.transferred(held, base, ())
    starts = free_runs.scored_from(held, bool(steady))
    old, new = free_runs.free_runs(held, before), free_runs.free_runs(held, after)
    gains = free_runs.gains(held, old, new, starts, state.setting.noise.sensor_sd, rng)
    return gains, (*shown, *free_runs.traces(held, "held_out", old, new, starts))


def _steady(state: State) -> list[Parameter]:
    """Parameters that belong to a record and hold all through it: other records have their own."""
    found = [a for a in state.accepted if not isinstance(a.cause, Unmodelled) and a.cause.search.steady]
    return [p for a in found for p in a.variant if p.record is not None]


def _base_setting(state: State, options: Options) -> Setting:
    """The base model without causes: its coefficients refitted where they are free."""
    est, start = state.est, replace(state.start, noise=state.setting.noise)
    if not state.nuisance:
        return start
    s, _ = state.at(start, state.now, ()).refit(start, (), 6)
    return free_runs.fitted_to_simulate(est, s, state.nuisance) if options.base_parameters == "identify" else s
