"""The steering laws and the bank of rungs: which numbers each frees, with priors in units of the craft itself.

T0, r95, d95, U0 and n0 are the craft's time, yaw rate, rudder or command, speed and revolutions (`Scales`).
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np

from ...estimation.selection.number import Candidate, Number
from .problem import COMMON, DELAY, SLOWNESS
from .windows import LAG, Scales

STEEPEST = 1.0
"""Largest damping of a hull, per sampling step: no time constant is shorter than a step."""


class Prior(NamedTuple):
    """Mean, standard deviation and range of a number."""

    mean: float
    sd: float
    low: float = -np.inf
    high: float = np.inf


class Craft(NamedTuple):
    """Units of the craft, the records' sampling step, s, the mean square of the measured wind, m2/s2, and a large
    sum of two thrusts, N."""

    scales: Scales
    step_s: float
    wind2: float
    thrust: float

    @property
    def gain(self) -> float:
        """Yaw acceleration per rudder or command, 1/s2."""
        return self.scales.rate / self.scales.rudder / self.scales.time_s

    @property
    def moment(self) -> float:
        """Yaw acceleration of a hard manoeuvre, rad/s2."""
        return self.scales.rate / self.scales.time_s


Priors = Callable[[Craft], dict[str, Prior]]
"""Prior of each number for a craft."""
Trials = Callable[[Craft], Sequence[tuple[float, ...]]]
"""Values that a rung is linearised at and started from, for a craft."""


@dataclass(frozen=True)
class Law:
    """What steers the craft.  needs : inputs of the records;  instead : laws that it replaces where they are there;
    seen : whether these inputs themselves say what steers the craft."""

    id: str
    family: str
    title: str
    priors: Priors
    needs: frozenset[str] = frozenset()
    instead: frozenset[str] = frozenset()
    seen: bool = False


@dataclass(frozen=True)
class Rung:
    """One thing that a simpler model lacks.

    extension : of the family.  trials : of its numbers, as differences from the prior means;  None: its tangent says
    what it brings.  of : cause, of which one rung only enters.  only, needs : laws and inputs.  bounding : it bounds
    the motion, so that linear damping may be negative.  doubtful : slow disturbances look like it, so that a likelihood
    ratio counts for nothing.
    """

    id: str
    title: str
    priors: Priors
    extension: str | None = None
    trials: Trials | None = None
    of: str = ""
    only: frozenset[str] = frozenset()
    needs: frozenset[str] = frozenset()
    commands_only: bool = False
    bounding: bool = False
    doubtful: bool = False

    def candidates(self, craft: Craft, damping: Number) -> list[Candidate]:
        """Ways in which it may enter; damping : the linear damping of the law, where it may be negative."""
        numbers = numbers_of(self.priors(craft))
        more = (damping,) if self.bounding else ()
        ways = self.trials(craft) if self.trials else [(None,) * len(numbers)]
        return [
            Candidate(
                self.of or self.id,
                (*(replace(n, trial=x) for n, x in zip(numbers, way, strict=True)), *more),
                kind=f"{self.id} {np.sign(way[0] or 0.0):g}",
            )
            for way in ways
        ]


def numbers_of(priors: Mapping[str, Prior]) -> tuple[Number, ...]:
    """Numbers as differences from their prior means."""
    return tuple(Number(name, p.sd, p.low - p.mean, p.high - p.mean) for name, p in priors.items())


def _damping(c: Craft, by_speed: bool) -> Prior:
    """Of linear damping: about 1/T0, negative, not steeper than a step allows."""
    unit = 1.0 / c.scales.time_s
    low = -max(STEEPEST / c.step_s, 2.0 * unit)
    speed = c.scales.speed if by_speed else 1.0
    return Prior(-unit / speed, 2.0 * unit / speed, low / speed, -0.02 * unit / speed)


def _still(c: Craft) -> Prior:
    """Of a damping that does not depend on the speed, beside one that does: positive, half of what is expected."""
    whole = _damping(c, False)
    return Prior(-0.5 * whole.mean, 0.5 * whole.sd, 0.0, -whole.low)


def _steering(c: Craft, of: float) -> Prior:
    """Of a gain; of: what it is multiplied by (1, U0^2, n0^2)."""
    return Prior(0.0, 3.0 * c.gain / of)


def _constant(c: Craft) -> dict[str, Prior]:
    return {"a": _damping(c, False), "b": _steering(c, 1.0)}


def _thruster(c: Craft) -> dict[str, Prior]:
    still, moving = (_damping(c, by_speed)._replace(high=0.0) for by_speed in (False, True))
    half = [p._replace(mean=0.5 * p.mean, sd=0.5 * p.sd) for p in (still, moving)]
    return {"a": half[0], "a1": half[1], "b": _steering(c, 1.0)}


def _flow(c: Craft) -> dict[str, Prior]:
    return {"a1": _damping(c, True), "b2": _steering(c, c.scales.speed**2)}


def _race(c: Craft) -> dict[str, Prior]:
    return {**_flow(c), "bn": _steering(c, c.scales.turns**2)}


def _steady_race(c: Craft) -> dict[str, Prior]:
    return {**_flow(c), "b": _steering(c, 1.0)}


def _azimuth(c: Craft) -> dict[str, Prior]:
    damping = {name: prior for name, prior in _thruster(c).items() if name != "b"}
    return damping | {"bn": _steering(c, c.scales.turns**2)}


GAINS = ("b", "b2", "bn", "bs")
"""Names of the numbers that a rudder, an order or a difference of orders is multiplied by."""
NOTHING = Law(
    "no_steering",
    "nomoto-1",
    "a yaw motion that dies away, whatever the steering",
    lambda c: {"a": _damping(c, False)},
)
"""What a recorded rudder or command must do better than, if it turns the craft."""
SPEED, TURNS, WIND, WIDE, PAIR, ASTERN = "speed", "n", "wind", "wide angles", "two thrusts", "astern"
ALL_AHEAD = (
    Law("constant", "nomoto-1", "moment and damping that do not depend on the speed (K, T)", _constant),
    Law(
        "rudder_in_flow", "rudder-in-flow", "a rudder in the flow: moment ~ U², damping ~ U (K', T')", _flow,
        frozenset({SPEED}),
    ),
    Law(
        "thruster", "thruster-in-flow", "thrusters: the moment does not depend on the speed, the damping does",
        _thruster, frozenset({SPEED}),
    ),
    Law(
        "rudder_in_race", "rudder-in-race", "a rudder in a propeller's race: moment ~ U² and n², damping ~ U", _race,
        frozenset({SPEED, TURNS}),
    ),
    Law(
        "rudder_in_steady_race", "rudder-in-steady-race",
        "a rudder in the race of a propeller at constant revolutions: a moment beside that ~ U², damping ~ U",
        _steady_race, frozenset({SPEED}),
    ),
    Law(
        "azimuth", "azimuth-thruster", "an azimuth thruster: moment ~ n² sin of its angle", _azimuth,
        frozenset({SPEED, TURNS, WIDE}), seen=True,
    ),
    Law(
        "twin_thrusters", "twin-thrusters",
        "two thrusters: the moment goes with the difference of the two, the damping with the speed", _thruster,
        frozenset({SPEED, PAIR}), frozenset({"thruster"}), seen=True,
    ),
)  # fmt: skip
"""The laws of craft that go ahead."""


def _through_rest(law: Law) -> Law:
    """The law of a rudder where the craft goes astern as well: on the way it is at rest, where |U| damps nothing."""
    signed = law.title.replace("U²", "U|U|").replace("damping ~ U", "damping ~ |U|")
    return replace(
        law,
        id=f"{law.id}_through_rest",
        family=f"{law.family}+still_damping",
        title=f"{signed}, and a damping that does not depend on the speed",
        priors=lambda c: law.priors(c) | {"still_damping": _still(c)},
        needs=law.needs | {ASTERN},
        instead=frozenset({law.id, "rudder_in_steady_race"}),
    )


LAWS = (*ALL_AHEAD, *(_through_rest(law) for law in ALL_AHEAD if law.id in ("rudder_in_flow", "rudder_in_race")))
"""All laws.  No propeller at constant revolutions drives a craft ahead and astern."""


def _delays(c: Craft) -> list[tuple[float, ...]]:
    least = max(0.5 * c.step_s, 0.03 * c.scales.time_s)
    every = [least * factor for factor in (1.0, 2.0, 4.0, 8.0)]
    return [(x,) for x in every if x < 0.6 * c.scales.time_s or x == least]


def _slownesses(c: Craft) -> list[tuple[float, ...]]:
    return [(c.scales.time_s / c.scales.rudder * factor,) for factor in (0.25, 0.5, 1.0, 2.0)]


def _lags(c: Craft) -> list[tuple[float, ...]]:
    """Of the lead, and of the second time constant beside its mean: a lag, and a lead."""
    return [(x, z * c.scales.time_s) for x, z in ((0.8, -0.3), (0.8, 0.25), (-1.6, -0.05), (-6.0, -0.25))]


def _shortest(c: Craft) -> float:
    """Shortest second time constant, s: a sampling step."""
    return max(c.step_s, 0.03 * c.scales.time_s)


NEUTRAL = Rung(
    "neutral_angle",
    "a neutral angle: rudder or command that holds a straight course",
    lambda c: {COMMON: Prior(0.0, 0.2 * c.scales.rudder)},
    "rudder_offset",
)
"""Every craft has one: it stands beside every law, and is no step of the ladder."""
RUNGS = (
    Rung(
        "quadratic_damping", "damping that grows with the yaw rate (r|r|)",
        lambda c: {"added_Nr_absr": Prior(0.0, c.moment / c.scales.rate**2, high=0.0)}, "yaw_damping_quadratic",
        of="damping_by_rate", bounding=True,
    ),
    Rung(
        "cubic_damping", "damping that grows with the yaw rate (r³)",
        lambda c: {"added_Nrrr": Prior(0.0, c.moment / c.scales.rate**3, high=0.0)}, "yaw_damping_cubic",
        of="damping_by_rate", bounding=True,
    ),
    Rung(
        "delay", "a delay between order and hull",
        lambda c: {DELAY: Prior(0.0, 0.3 * c.scales.time_s, 0.0, 2.0 * c.scales.time_s)}, trials=_delays,
    ),
    Rung(
        "rate_limit", "a limit of the rate at which the order is followed",
        lambda c: {SLOWNESS: Prior(0.0, c.scales.time_s / c.scales.rudder, 0.0)}, trials=_slownesses,
        commands_only=True,
    ),
    Rung(
        "second_order", "a second time constant",
        lambda c: {
            "lead": Prior(0.0, 4.0, -20.0, 1.0),
            LAG: Prior(0.5 * c.scales.time_s, 0.5 * c.scales.time_s, _shortest(c), 6.0 * c.scales.time_s),
        },
        "second_order_lead", _lags,
    ),
    Rung(
        "asymmetry", "more effect to one side than to the other",
        lambda c: {"rudder_asymmetry": Prior(0.0, 0.15, -0.8, 0.8)}, "rudder_asymmetry",
    ),
    Rung(
        "stall", "an effect that levels off at large angles or commands",
        lambda c: {"rudder_stall": Prior(0.0, 0.5 / c.scales.rudder, 0.0, 4.0 / c.scales.rudder)}, "rudder_stall",
    ),
    Rung(
        "hull_asymmetry", "a yaw moment ~ U² on a straight course",
        lambda c: {"c": Prior(0.0, 0.2 * c.moment / c.scales.speed**2)},
        only=frozenset({"thruster", "twin_thrusters"}),
    ),
    Rung(
        "unequal_thrusters", "one thruster that turns the craft more than the other",
        lambda c: {"bs": Prior(0.0, 0.2 * c.moment / c.thrust)}, only=frozenset({"twin_thrusters"}),
    ),
    Rung(
        "measured_wind", "the measured wind",
        lambda c: dict.fromkeys(("wind_across", "wind_both"), Prior(0.0, 0.3 * c.moment / c.wind2)),
        "measured_wind", of="wind", needs=frozenset({WIND}),
    ),
    Rung(
        "heading_moment", "a moment that goes with the heading, as of wind or of a current",
        lambda c: dict.fromkeys(("heading_moment_cos", "heading_moment_sin"), Prior(0.0, 0.1 * c.moment)),
        "heading_moment", of="wind", doubtful=True,
    ),
)  # fmt: skip
