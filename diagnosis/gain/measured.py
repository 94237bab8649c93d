"""Causes that predict left-out training records worse are left out of the extended model."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from ...estimation.filters.innovations.estimator import estimator
from ...estimation.filters.innovations.vector import SENSORS
from ..candidate import Unmodelled
from ..residuals.criterion import without
from ..state import State
from . import free_runs
from .guard import WORSE
from .left_out import Blocks, best_ratio, left_out_errors, motions, worst_ratio

if TYPE_CHECKING:
    from ...datasets.record import Record
    from ...estimation.filters.innovations.estimator import Estimator
    from ...estimation.filters.innovations.settings import Parameter, Setting
    from ..causes.base import Cause
    from ..options import Options

GAINS = 0.95
"""Ratio of errors with a cause to those without it, in its best channel, from which it gains too little."""


@dataclass(frozen=True)
class Predicted:
    """The state without the causes that were left out, the setting that it is simulated at, and what was left out:
    causes that predict worse, and causes that gain too little."""

    state: State
    setting: Setting
    failing: tuple[Cause, ...]
    idle: tuple[Cause, ...]


def predicting(state: State, options: Options, gaining: bool = False) -> Predicted:
    """Leave out causes as long as some channel of training records, left out in turn, is predicted worse with them.

    The held-out records take no part in it: they are scored once, at the end.

    gaining : leave out as well what makes no channel of these records better by a twentieth.
    """
    failing: list[Cause] = []
    base = base_setting(state, options)
    rule = _Rule(options, bool(_steady(state)), motions(state.est))
    least = rule.errors(state.est, base, state.nuisance)
    here = _trial(state, base, least, rule)
    while here.worst > WORSE and here.state.accepted:
        trials = [(a, _trial(without(here.state, a), base, least, rule)) for a in here.state.accepted]
        last, here = min(trials, key=lambda trial: trial[1].worst)
        failing += [] if isinstance(last.cause, Unmodelled) else [last.cause]
    here, idle = _without_idle(here, base, least, rule) if gaining else (here, [])
    return Predicted(here.state, here.setting, tuple(failing), tuple(idle))


def _without_idle(here: _Trial, base: Setting, least: Blocks, rule: _Rule) -> tuple[_Trial, list[Cause]]:
    """The trial without causes that gain too little, the least useful first, and these causes; what no free run shows
    (waves, a clock's errors) stays."""
    idle: list[Cause] = []
    while True:
        found: list[tuple[float, Cause, _Trial]] = []
        for a in here.state.accepted:
            if a.variant and not isinstance(a.cause, Unmodelled):
                rest = _fitted(without(here.state, a), base, least, rule)
                ratio = best_ratio(rest.errors, here.errors, np.random.default_rng(rule.options.seed))
                found.append((ratio, a.cause, rest))
        ratio, cause, rest = max(found, key=lambda item: item[0], default=(0.0, None, here))
        if cause is None or ratio <= GAINS:
            return here, idle
        here, idle = rest if rest.state.accepted else _trial(rest.state, base, least, rule), [*idle, cause]


@dataclass(frozen=True)
class _Rule:
    """How records are left out: per_record says whether some cause belongs to a record; motion is the channels' own."""

    options: Options
    per_record: bool
    motion: Mapping[int, float]

    def errors(self, est: Estimator, s: Setting, parameters: Sequence[Parameter]) -> Blocks:
        """Errors on what was left out, of a model that was fitted to all records."""
        return left_out_errors(est, s, parameters, self.options.base_parameters == "identify", self.per_record)


class _Trial(NamedTuple):
    """A state with the setting that it is simulated at, its errors on what was left out, and their worst ratio to the
    base model's."""

    state: State
    setting: Setting
    errors: Blocks
    worst: float


def _trial(state: State, base: Setting, least: Blocks, rule: _Rule) -> _Trial:
    """base, least : the base model, which a state without causes is, and its errors on what was left out."""
    return _fitted(state, base, least, rule) if state.accepted else _Trial(state, base, least, 1.0)


def _fitted(state: State, base: Setting, least: Blocks, rule: _Rule) -> _Trial:
    """The state as it is fitted, also without causes."""
    setting = _simulating(state, base, rule.options)
    errors = rule.errors(state.est, setting, _moved(state))
    worst = worst_ratio(least, errors, rule.motion, np.random.default_rng(rule.options.seed))
    return _Trial(state, setting, errors, worst)


def _simulating(state: State, base: Setting, options: Options) -> Setting:
    """The setting that the extended model is simulated at: free coefficients are fitted to free runs.

    The fit starts from the innovations' setting, and from the base model's coefficients with the causes' sizes.
    """
    if options.base_parameters != "identify":
        return state.setting
    est, moved = state.est, _moved(state)
    starts = [state.setting, state.setting]
    for p in state.nuisance:
        starts[1] = est.at(starts[1], p, est.value(base, p))
    return free_runs.fitted_to_simulate(est, starts, moved)


def _moved(state: State) -> list[Parameter]:
    """The parameters of the ship: free runs tell nothing of a sensor's."""
    numbers = (f"{name}_{kind}" for name in SENSORS for kind in ("scale", "bias", "delay"))
    sensors = {state.est.index[name] for name in (*numbers, "axis_misalignment", "reference_speed")}
    return [p for p in state.parameters if not {entry for entry, _ in p.slots} & sensors]


def held_out_setting(state: State, final: Setting, records: Sequence[Record]) -> tuple[Estimator, Setting]:
    """Held-out records under the filter, and the final setting there: what belongs to a record is estimated from its
    first part."""
    est = state.est
    held = replace(
        estimator(est.model, records, est.unit, est.threads, est.terms), rudder_sd=est.rudder_sd, base=est.base
    )
    of_record = [p for a in state.accepted for p in a.variant if p.record is not None]
    return held, free_runs.adapted(held, free_runs.transferred(held, final, of_record), _steady(state))


def of_state(state: State, final: Setting, records: Sequence[Record]) -> dict[str, dict[str, float]]:
    """As `of_held_out`, of the accepted causes; nothing without records."""
    steady = _steady(state)
    return of_held_out(*held_out_setting(state, final, records), steady) if records and steady else {}


def of_held_out(held: Estimator, s: Setting, steady: Sequence[Parameter]) -> dict[str, dict[str, float]]:
    """Name of a held-out record -> what belongs to it (current, wind), as coefficients of the extended model.

    held, s : the records under the filter, and the setting there.  steady : the parameters of a record.
    """
    entries = {entry for p in steady for entry, _ in p.slots}
    names = {name: entry for name, entry in held.index.items() if entry in entries}
    return {
        record: {name: float(s.vectors[held.rows(i)[0], entry]) for name, entry in names.items()}
        for i, record in enumerate(held.record_names if names else ())
    }


def _steady(state: State) -> list[Parameter]:
    """Parameters that belong to a record and hold all through it: other records have their own."""
    found = [a for a in state.accepted if not isinstance(a.cause, Unmodelled) and a.cause.search.steady]
    return [p for a in found for p in a.variant if p.record is not None]


def base_setting(state: State, options: Options) -> Setting:
    """The base model without causes: as it is given or identified; else its uncertain coefficients refitted."""
    start = replace(state.start, noise=state.setting.noise)
    if not state.nuisance or options.base_parameters == "identify":
        return start
    return state.at(start, state.now, ()).refit(start, (), 6)[0]
