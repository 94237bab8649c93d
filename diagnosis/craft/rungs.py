"""The steering laws and the bank of rungs: which numbers each frees, with priors in units of the craft (`Scales`).

A row of LAWS or RUNGS says which numbers belong together; PRIORS says once what is expected of each.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np

from ...estimation.selection.number import Candidate, Number
from .problem import COMMON, DELAY, SLOWNESS
from .windows import LAG, LEAD, Scales

STEEPEST = 1.0
"""Largest damping of a hull, per sampling step: no time constant is shorter than a step."""


class Prior(NamedTuple):
    """Mean, standard deviation and range of a number."""

    mean: float
    sd: float
    low: float = -np.inf
    high: float = np.inf

    def number(self, name: str) -> Number:
        """The number as its difference from the mean."""
        return Number(name, self.sd, self.low - self.mean, self.high - self.mean)


def _damping(c: Scales, by_speed: bool) -> Prior:
    """Of linear damping: about 1/T0, negative, not steeper than a step allows."""
    unit = 1.0 / c.time_s / (c.speed if by_speed else 1.0)
    return Prior(-unit, 2.0 * unit, -max(STEEPEST * c.time_s / c.step_s, 2.0) * unit, -0.02 * unit)


def _shared(whole: Prior) -> Prior:
    """Of a damping that is one of two."""
    return Prior(0.5 * whole.mean, 0.5 * whole.sd, whole.low, 0.0)


def _still(c: Scales) -> Prior:
    mean, sd, low, _ = _shared(_damping(c, False))
    return Prior(-mean, sd, 0.0, -low)


def _lag(c: Scales) -> Prior:
    """Of a second time constant, not shorter than a sampling step."""
    return Prior(0.5 * c.time_s, 0.5 * c.time_s, max(c.step_s, 0.03 * c.time_s), 6.0 * c.time_s)


PRIORS: dict[str, Callable[[Scales], Prior]] = {
    "a": lambda c: _damping(c, False),
    "a1": lambda c: _damping(c, True),
    "still_damping": _still,
    "b": lambda c: Prior(0.0, 3.0 * c.gain),
    "b2": lambda c: Prior(0.0, 3.0 * c.gain / c.speed**2),
    "bn": lambda c: Prior(0.0, 3.0 * c.gain / c.turns**2),
    "bs": lambda c: Prior(0.0, 0.2 * c.moment / c.thrust),
    "c": lambda c: Prior(0.0, 0.2 * c.moment / c.speed**2),
    COMMON: lambda c: Prior(0.0, 0.2 * c.rudder),
    "added_Nr_absr": lambda c: Prior(0.0, c.moment / c.rate**2, high=0.0),
    "added_Nrrr": lambda c: Prior(0.0, c.moment / c.rate**3, high=0.0),
    DELAY: lambda c: Prior(0.0, 0.3 * c.time_s, 0.0, 2.0 * c.time_s),
    SLOWNESS: lambda c: Prior(0.0, c.time_s / c.rudder, 0.0),
    LEAD: lambda c: Prior(0.0, 4.0, -20.0, 1.0),
    LAG: _lag,
    "rudder_asymmetry": lambda c: Prior(0.0, 0.15, -0.8, 0.8),
    "rudder_stall": lambda c: Prior(0.0, 0.5 / c.rudder, 0.0, 4.0 / c.rudder),
    "wind_across": lambda c: Prior(0.0, 0.3 * c.moment / c.wind2),
    "wind_both": lambda c: Prior(0.0, 0.3 * c.moment / c.wind2),
    "heading_moment_cos": lambda c: Prior(0.0, 0.1 * c.moment),
    "heading_moment_sin": lambda c: Prior(0.0, 0.1 * c.moment),
}
"""Number -> its prior for a craft."""
GAINS = ("b", "b2", "bn", "bs")
"""Numbers that a rudder, an order or a difference of orders is multiplied by."""


def priors_of(names: Sequence[str], c: Scales) -> dict[str, Prior]:
    """The priors of numbers that belong together."""
    found = {name: PRIORS[name](c) for name in names}
    return {n: _shared(p) if {"a", "a1"} <= found.keys() and n in ("a", "a1") else p for n, p in found.items()}


@dataclass(frozen=True)
class Law:
    """What steers the craft.  needs : inputs of the records;  instead : laws that it replaces where they are there;
    seen : whether these inputs themselves say what steers the craft."""

    id: str
    family: str
    title: str
    numbers: tuple[str, ...]
    needs: frozenset[str] = frozenset()
    instead: frozenset[str] = frozenset()
    seen: bool = False


@dataclass(frozen=True)
class Rung:
    """One thing that a simpler model lacks.

    extension : of the family.  trials : values of its numbers, as differences from the prior means, that it is
    linearised at and started from;  None: its tangent says what it brings.  of : cause, of which one rung only enters.
    only, needs : laws and inputs.  bounding : it bounds the motion, so that linear damping may be negative.  doubtful :
    slow disturbances look like it, so that a likelihood ratio counts for nothing.
    """

    id: str
    title: str
    numbers: tuple[str, ...]
    extension: str | None = None
    trials: Callable[[Scales], Sequence[tuple[float, ...]]] | None = None
    of: str = ""
    only: frozenset[str] = frozenset()
    needs: frozenset[str] = frozenset()
    commands_only: bool = False
    bounding: bool = False
    doubtful: bool = False

    def candidates(self, c: Scales, damping: Number) -> list[Candidate]:
        """Ways in which it may enter; damping : the linear damping of the law, where it may be negative."""
        numbers = [p.number(name) for name, p in priors_of(self.numbers, c).items()]
        more = (damping,) if self.bounding else ()
        ways = self.trials(c) if self.trials else [(None,) * len(numbers)]
        return [
            Candidate(
                self.of or self.id,
                (*(replace(n, trial=x) for n, x in zip(numbers, way, strict=True)), *more),
                kind=f"{self.id} {np.sign(way[0] or 0.0):g}",
            )
            for way in ways
        ]


SPEED, TURNS, WIND, WIDE, PAIR, ASTERN = "speed", "n", "wind", "wide angles", "two thrusts", "astern"
NOTHING = Law("no_steering", "nomoto-1", "a yaw motion that dies away, whatever the steering", ("a",))
"""What a recorded rudder or command must do better than, if it turns the craft."""
ALL_AHEAD = (
    Law("constant", "nomoto-1", "moment and damping that do not depend on the speed (K, T)", ("a", "b")),
    Law(
        "rudder_in_flow", "rudder-in-flow", "a rudder in the flow: moment ~ U², damping ~ U (K', T')", ("a1", "b2"),
        frozenset({SPEED}),
    ),
    Law(
        "thruster", "thruster-in-flow", "thrusters: the moment does not depend on the speed, the damping does",
        ("a", "a1", "b"), frozenset({SPEED}),
    ),
    Law(
        "rudder_in_race", "rudder-in-race", "a rudder in a propeller's race: moment ~ U² and n², damping ~ U",
        ("a1", "b2", "bn"), frozenset({SPEED, TURNS}),
    ),
    Law(
        "rudder_in_steady_race", "rudder-in-steady-race",
        "a rudder in the race of a propeller at constant revolutions: a moment beside that ~ U², damping ~ U",
        ("a1", "b2", "b"), frozenset({SPEED}),
    ),
    Law(
        "azimuth", "azimuth-thruster", "an azimuth thruster: moment ~ n² sin of its angle",
        ("a", "a1", "bn"), frozenset({SPEED, TURNS, WIDE}), seen=True,
    ),
    Law(
        "twin_thrusters", "twin-thrusters",
        "two thrusters: the moment goes with the difference of the two, the damping with the speed",
        ("a", "a1", "b"), frozenset({SPEED, PAIR}), frozenset({"thruster"}), seen=True,
    ),
)  # fmt: skip


def _through_rest(law: Law) -> Law:
    """The law of a rudder where the craft goes astern as well: on the way it is at rest, where |U| damps nothing."""
    signed = law.title.replace("U²", "U|U|").replace("damping ~ U", "damping ~ |U|")
    return replace(
        law,
        id=f"{law.id}_through_rest",
        family=f"{law.family}+still_damping",
        title=f"{signed}, and a damping that does not depend on the speed",
        numbers=(*law.numbers, "still_damping"),
        needs=law.needs | {ASTERN},
        instead=frozenset({law.id, "rudder_in_steady_race"}),
    )


LAWS = (*ALL_AHEAD, *(_through_rest(law) for law in ALL_AHEAD if law.id in ("rudder_in_flow", "rudder_in_race")))
"""All laws.  No propeller at constant revolutions drives a craft ahead and astern."""


def _delays(c: Scales) -> list[tuple[float, ...]]:
    least = max(0.5 * c.step_s, 0.03 * c.time_s)
    every = [least * factor for factor in (1.0, 2.0, 4.0, 8.0)]
    return [(x,) for x in every if x < 0.6 * c.time_s or x == least]


def _shares(name: str, c: Scales, *shares: float) -> list[tuple[float, ...]]:
    """Shares of the prior standard deviation of a number whose tangent tells little."""
    return [(share * PRIORS[name](c).sd,) for share in shares]


NEUTRAL = Rung(
    "neutral_angle", "a neutral angle: rudder or command that holds a straight course", (COMMON,), "rudder_offset"
)
"""Every craft has one: it stands beside every law, and is no step of the ladder."""
RUNGS = (
    Rung(
        "quadratic_damping", "damping that grows with the yaw rate (r|r|)", ("added_Nr_absr",),
        "yaw_damping_quadratic", lambda c: _shares("added_Nr_absr", c, -0.3, -1.0), of="damping_by_rate", bounding=True,
    ),
    Rung(
        "cubic_damping", "damping that grows with the yaw rate (r³)", ("added_Nrrr",),
        "yaw_damping_cubic", lambda c: _shares("added_Nrrr", c, -0.3, -1.0), of="damping_by_rate", bounding=True,
    ),
    Rung("delay", "a delay between order and hull", (DELAY,), trials=_delays),
    Rung(
        "rate_limit", "a limit of the rate at which the order is followed", (SLOWNESS,),
        trials=lambda c: _shares(SLOWNESS, c, 0.25, 0.5, 1.0, 2.0), commands_only=True,
    ),
    Rung(
        "second_order", "a second time constant", (LEAD, LAG), "second_order_lead",
        lambda c: [(x, z * c.time_s) for x, z in ((0.8, -0.3), (0.8, 0.25), (-1.6, -0.05), (-6.0, -0.25))],
    ),
    Rung("asymmetry", "more effect to one side than to the other", ("rudder_asymmetry",), "rudder_asymmetry"),
    Rung(
        "stall", "an effect that levels off at large angles or commands", ("rudder_stall",), "rudder_stall",
        lambda c: _shares("rudder_stall", c, 0.3, 1.0),
    ),
    Rung(
        "hull_asymmetry", "a yaw moment ~ U² on a straight course", ("c",),
        only=frozenset({"thruster", "twin_thrusters"}),
    ),
    Rung(
        "unequal_thrusters", "one thruster that turns the craft more than the other", ("bs",),
        only=frozenset({"twin_thrusters"}),
    ),
    Rung(
        "measured_wind", "the measured wind", ("wind_across", "wind_both"),
        "measured_wind", of="wind", needs=frozenset({WIND}),
    ),
    Rung(
        "heading_moment", "a moment that goes with the heading, as of wind or of a current",
        ("heading_moment_cos", "heading_moment_sin"), "heading_moment", of="wind", doubtful=True,
    ),
)  # fmt: skip
