"""Causes in the steering gear: what stands between the recorded rudder angle, or its command, and the hull's rudder."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from ...checks.base import Prior
from ...datasets.signals import lagged
from ...estimation.filters.innovations.settings import Parameter
from ..innovations.searches import ByChangePoint, ByScan, ByScore, longest, refitted
from .base import DEGREE, Cause, NotTestable, Number, StageCause

if TYPE_CHECKING:
    from ...estimation.filters.innovations.estimator import Estimator
    from ..innovations.state import Candidate, State, Variant
    from ..result import Finding

LIMITS = (1.5, 1.2, 1.0, 0.9985, 0.995, 0.985, 0.97, 0.9, 0.8, 0.6, 0.4, 0.2)
"""Limits that are tried first, as shares of the command's largest value: just below it a little changes much."""


class RudderOffset(Cause):
    """The rudder's neutral angle: delta_hull = delta_recorded + delta0, delta0 in rad."""

    id, where, unit = "rudder_offset", "rudder", "rad"
    search, extension = ByScore(), "rudder_offset"
    number = Number("delta0", ("rudder_offset",), scale=0.05 * DEGREE)
    smallest = power_size = 0.1 * DEGREE
    prior = Prior(2.0 * DEGREE)
    separate_by = "straight runs at two speeds: what an offset does grows with the speed squared"


def own_neutral_angles(findings: Iterable[Finding]) -> dict[str, float]:
    """Record -> its own neutral rudder angle, rad, where records are found to have different ones."""
    angles = (size for f in findings if f.cause == RudderOffset.id for size in f.sizes)
    return {size.record: size.value for size in angles if size.record is not None}


class RudderDelay(Cause):
    """The hull feels the rudder late: delta_hull(t) = delta_recorded(t - tau), tau in s."""

    id, where, unit = "rudder_delay", "rudder", "s"
    search = ByScore((0.3, 1.0, 2.0, 3.5))
    number = Number("tau", ("rudder_delay",), scale=0.05, low=0.0, high=8.0)
    smallest, power_size = 0.05, 0.2
    prior = Prior(0.5, (0.02, 0.05, 0.15))
    separate_by = "rudder steps with the rudder angle recorded at the stock and on the bridge at once"


class RudderBacklash(Cause):
    """Play of +- b rad between the recorded and the acting rudder (linkage wear): the hull's rudder follows only
    once the recorded one has moved through it."""

    id, where, unit = "rudder_backlash", "rudder", "rad"
    search = ByScore((0.15 * DEGREE, 0.4 * DEGREE, DEGREE, 2.0 * DEGREE))
    number = Number("b", ("rudder_backlash",), scale=0.1 * DEGREE, low=0.0, high=12.0 * DEGREE)
    smallest, power_size = 0.1 * DEGREE, 0.3 * DEGREE
    prior = Prior(5.0 * DEGREE, (0.5 * DEGREE, 2.0 * DEGREE))
    separate_by = "slow small-angle rudder sweeps in both directions"


class RudderSensorPlay(StageCause):
    """Play of +- b rad in the drive of the rudder's angle sensor: the recorded angle lags the rudder's by b, in the
    direction in which that moves; the hull feels the rudder before the record shows it."""

    id, where, unit, stage = "rudder_sensor_play", "rudder", "rad", "looked for by free runs of the model"
    number = Number("b", ("rudder_hysteresis",), scale=0.1 * DEGREE, low=0.0)
    smallest = 0.1 * DEGREE
    prior = Prior(5.0 * DEGREE, (0.5 * DEGREE, 2.0 * DEGREE), angle=True)
    separate_by = "the angle read at the stock after the rudder came from either side"


class RudderSensorDelay(StageCause):
    """The recorded rudder angle is late beside the other channels: delta_recorded(t) = delta_hull(t - tau), tau in s;
    the hull feels the rudder before the record shows it."""

    id, where, unit, stage = "rudder_sensor_delay", "rudder", "s", "looked for by free runs of the model"
    number = Number("tau", ("rudder_sensor_delay",), scale=0.05, low=0.0)
    smallest = 0.05
    prior = Prior(0.5, (0.02, 0.05, 0.15), angle=True)
    separate_by = "one clock that stamps each channel when it is measured"


class CommandLimit(Cause):
    """Base class of what the rudder cannot follow of its command."""

    where = "rudder"
    separate_by = "record the rudder angle itself beside the command"

    def variants(self, est: Estimator) -> Sequence[Variant]:
        if not est.commanded:
            raise NotTestable("the rudder column is the angle itself, which already shows its limits")
        return super().variants(est)


def rates(state: State) -> list[float]:
    """Rates (rad/s) about and below the quietened commands' largest."""
    d = state.est.segments
    seen = max(float(np.max(np.abs(np.diff(q) / np.diff(x.time)))) for q, x in zip(_quiet(state), d, strict=True))
    return [share * seen for share in LIMITS]


def angles(state: State) -> list[float]:
    """Angles (rad) about and below the quietened commands' largest."""
    seen = max(float(np.mean(np.abs(q)[np.abs(q) > 0.98 * np.abs(q).max()])) for q in _quiet(state))
    return [share * seen for share in LIMITS]


def _quiet(state: State) -> list[np.ndarray]:
    return [lagged(d.rudder, 1.5 * d.step_s, d.step_s) for d in state.est.segments]


class RudderRateLimit(CommandLimit):
    """The rudder cannot turn faster than a rate (rad/s); only where the rudder column is a command."""

    id, unit = "rudder_rate_limit", "rad/s"
    search = ByScan("rudder_rate_limit", rates)
    number = Number("rate", ("rudder_rate_limit",), scale=0.01 * DEGREE, low=0.0)
    prior = Prior(40.0, (4.1, 1.9, 0.95, 0.48, 0.24), limit=True)


class RudderSaturation(CommandLimit):
    """The rudder stops at an angle (rad) short of the command; only where the rudder column is a command."""

    id, unit = "rudder_saturation", "rad"
    search = ByScan("rudder_saturation", angles)
    number = Number("limit", ("rudder_saturation",), scale=0.05 * DEGREE, low=0.0)
    prior = Prior(20.0, (1 / (8 * DEGREE), 1 / (15 * DEGREE), 1 / (25 * DEGREE)), limit=True)


class RudderEffectiveness(Cause):
    """Rudder force over what is modelled, as a share more: delta_hull = (1 + e) delta_recorded (-0.2: 20 % lost)."""

    gains = ("b", "b1")  # turning gains of response models, which it is nothing else than

    id, where, unit = "rudder_effectiveness", "rudder", "1"
    search, extension = ByScore(), "rudder_effectiveness"
    number = Number("e", ("rudder_effectiveness",), scale=0.01, low=-0.95, high=2.0)
    smallest, power_size = 0.01, 0.02
    prior = Prior(0.3)
    separate_by = "a bollard or captive rudder-force test, or rudder angles from small to hard over"

    def stands_beside_numbers(self, is_3dof: bool) -> bool:
        return is_3dof  # else it is the turning gain


class RudderFault(Cause):
    """Sudden loss (or gain) of rudder force: effectiveness 1 + e from time t0 (s) of the record on."""

    id, where, unit = "rudder_fault", "rudder", "1, s"
    search = ByChangePoint()
    smallest, power_size = 0.02, 0.1
    prior = Prior(0.3)
    separate_by = "a rudder-force check before and after"

    def variants(self, est: Estimator) -> Sequence[Variant]:
        e = Parameter("e", "1", ((est.index["rudder_fault"], 1.0),), low=-1.0, high=1.0, scale=0.02)
        slots = ((est.index["rudder_fault_time"], 1.0),)
        return [(e, Parameter("t0", "s", slots, low=0.0, high=longest(est), scale=1.0))]

    def simpler(self, state: State, candidate: Candidate, before: float, rng: np.random.Generator) -> Candidate | None:
        """The rudder's effectiveness, where the fault has come to act before the rudder moves."""
        steady = RudderEffectiveness()
        est, (e, t0) = state.est, candidate.variant
        firsts = [d for i, d in enumerate(est.segments) if i == 0 or d.record != est.segments[i - 1].record]
        moved = [d.time[np.argmax(np.abs(d.rudder - d.rudder[0]) > 0.5 * np.ptp(d.rudder))] for d in firsts]
        untried = steady in state.bank and steady not in state.causes
        if not untried or e.record is not None or est.value(candidate.setting, t0) > min(moved):
            return None
        (variant,) = state.bank[steady]
        s = replace(state.setting, noise=candidate.setting.noise)
        s = est.at(s, variant[0], est.value(candidate.setting, e))
        return refitted(steady, state, variant, s, 1, 1.0, before)
