"""Forces X, Y, N along the measured motion that no cause of the bank explains, as data: what they may follow.

Each is told as what it depends on.  Where the motion that it follows is one that a model simulates, it is a term of
an extended model (`models.families.extensions`), and its numbers are the parameters of that; a force in time is not.
"""

from __future__ import annotations

import itertools
from collections.abc import Callable, Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from ...estimation.selection.number import Candidate, Number
from ...models.families.extensions import WAVES_OF_PLACE, extension_of, is_made_up
from ..free_runs.bank import Place
from ..free_runs.motion import Motion, lagged
from .catalogue import FORCE, force_units, forces_of

if TYPE_CHECKING:
    from ..free_runs.motion import Series
    from ..free_runs.problem import FreeRuns

AXES = {"X": "surge force", "Y": "sway force", "N": "yaw moment", "R": "yaw moment"}
UNITS = {"X": "N", "Y": "N", "N": "N m", "R": "rad/s^k"}
"""Units of forces: R is the yaw moment of a response model, in the units of its highest derivative."""
BODY = {"R": "N"}
"""Axis of a response model -> that of the body, by which a force is told."""
WIDE = 5.0
"""Prior standard deviation of a force as a factor on that of a steady force of no cause."""
COUNTS = ("once", "twice", "three times", "four times")
MOTIONS = {"v": "drift", "r": "yaw rate", "d": "rudder angle"}
"""What forces follow; response models have no drift."""
LAGS = (0.25, 0.5, 1.0, 2.0, 4.0)
"""Times, in ship lengths sailed, that a force may lag behind the motion."""
PERIODS = (0.7, 12.0)
"""Shortest and longest period, in ship lengths sailed."""
MOST_PERIODS = 360
"""Of all axes together."""
STEPS = 9
"""Times at which a force may begin, spread over the longest record."""
DRIFTS = {"u": ("speed", 0.05), "v": ("sway velocity", 0.05), "r": ("yaw rate", 0.05), "psi": ("heading", 0.1)}
"""State -> its sensor in words, and prior standard deviation of its drift through the longest record: of the approach
speed, of U/L, rad."""
READINGS = {
    "heading": ("current, wind or swell from one side, or a compass that errs with the heading",
                "turn through all headings, at another place or on another day"),
    "speed": ("resistance or thrust that goes with the speed in another way", "run straight at three speeds or more"),
    "drift": ("damping of another form, or flow over the hull that separates",
              "turn with rudder of several sizes to both sides"),
    "yaw rate": ("damping of another form", "turn with rudder of several sizes to both sides"),
    "rudder angle": ("a rudder whose force is not as the model has it, or that works differently to each side",
                     "turn with rudder of several sizes to both sides"),
    "place": ("a bank, shallow water, a lee, or a current that differs from place to place",
              "sail the same track the other way, and another track"),
    "past": ("memory of the flow, a slow steering gear, or a filter in the logger",
             "hold the rudder for long, and move it quickly, in turn"),
    "time": ("wind, current, waves, load or engine that changed, or a sensor that drifts",
             "repeat the same manoeuvre at another time"),
    "event": ("a tug, a gust front, a lee, the wake of a passing ship, or shallow water for a while",
              "repeat the same manoeuvre at another time and place"),
}  # fmt: skip
"""Variable -> what a force that depends on it may be, and the manoeuvre that would tell."""

Term = Callable[[Motion, str], np.ndarray]
"""Force, N, or moment, N m, (N,) along a motion on an axis, for a number of one."""


@dataclass(frozen=True)
class Shape:
    """What a force follows.

    depends_on : variables, in words.  how : in a sentence, after the force's name.
    terms : number -> its force; `{}` in a name stands for the axis.
    extensions : of a family, that hold the numbers as parameters (whose names are the part before @); none where no
    model simulates it.
    held : further parameters of the extensions, with their values.
    """

    depends_on: tuple[str, ...]
    how: str
    terms: Mapping[str, Term]
    extensions: tuple[str, ...] = ()
    held: tuple[tuple[str, float], ...] = ()


@dataclass(frozen=True)
class Force:
    """A shape on an axis X, Y or N; or the drift of the sensor of a state."""

    axis: str
    shape: Shape

    @property
    def id(self) -> str:
        """What tells it from all others."""
        return f"{self.axis} {self.shape.how}"

    @property
    def text(self) -> str:
        """A yaw moment that depends on ..., in words."""
        if self.axis in AXES:
            return f"a {AXES[self.axis]} that {self.shape.how}"
        return f"a recorded {DRIFTS[self.axis][0]} that {self.shape.how}"

    @property
    def extensions(self) -> list[str]:
        """Extensions of a family that hold its numbers; none where the family cannot hold all."""
        names = [name.format(self.axis) for name in self.shape.extensions]
        return names if all(map(is_made_up, names)) else []

    @property
    def at_once(self) -> bool:
        """Whether it holds a force that is linear in a motion now, which numbers of the model are as well."""
        return any("_now@" in name for name in self.shape.terms)

    def parameters(self, values: Mapping[str, float]) -> Iterator[tuple[str, dict[str, float]]]:
        """Extensions with their parameters for values of the numbers."""
        known = self.held | {name.partition("@")[0]: value for name, value in values.items()}
        for extension in self.extensions:
            yield extension, {name: known[name] for name in extension_of(extension).units}

    def unit(self, name: str) -> str:
        """Unit of one of its numbers."""
        if self.axis not in AXES:
            first, growth = {"u": ("m/s", "m/s2"), "v": ("m/s", "m/s2"), "r": ("rad/s", "rad/s2"),
                             "psi": ("rad", "rad/s")}[self.axis]  # fmt: skip
            return first if "_first" in name else growth
        known = {n: unit for extension in self.extensions for n, unit in extension_of(extension).units.items()}
        return known.get(name.partition("@")[0], UNITS[self.axis])

    @property
    def held(self) -> dict[str, float]:
        """Further parameters of the extensions."""
        return {name.format(self.axis): value for name, value in self.shape.held}


def reading_of(force: Force) -> tuple[str, str]:
    """What a force may be, and the manoeuvre that would tell."""
    if force.axis not in AXES:
        return "a sensor that warms up, or integrates an error", READINGS["time"][1]
    first = force.shape.depends_on[0]
    return READINGS[next(word for word in READINGS if first.startswith(word))]


def shapes(
    axes: Collection[str], length_s: float, longest_s: float, places: Mapping[str, tuple[float, float]], turned: float
) -> list[Shape]:
    """Every shape on the axes of a model, for a ship that sails her length in length_s and records of at most
    longest_s.

    places : north, east -> the first place that is reached, m, and the span of all of them, m.  turned : range of the
    headings, rad: of less than half a wave the records show a steady force.
    """
    motions, speed = [x for x in MOTIONS if x != "v" or "Y" in axes], "X" in axes
    return [
        *(_by_heading(count) for count in range(1, len(COUNTS) + 1) if count * turned >= np.pi),
        *_by_motion(motions),
        *([_by_speed()] if speed else []),
        *(shape for x in motions for share in LAGS for shape in _by_past(x, share * length_s)),
        *(_by_place(side, first_m, span_m) for side, (first_m, span_m) in places.items()),
        *_in_time(longest_s, motions),
        *map(_periodic, _periods(length_s, longest_s, MOST_PERIODS // len(axes))),
    ]


def _by_heading(count: int) -> Shape:
    name = f"{{}}_heading_{count}"
    terms: dict[str, Term] = {
        f"{name}_cos": lambda m, axis: np.cos(count * m.heading),
        f"{name}_sin": lambda m, axis: np.sin(count * m.heading),
    }
    return Shape(("heading",), f"depends on the heading, {COUNTS[count - 1]} a turn", terms, (name,))


def _by_motion(motions: Collection[str]) -> Iterator[Shape]:
    """Products of v', r' and the rudder angle: the same to both sides, and with another sign to each."""
    for x in motions:
        word = MOTIONS[x]
        yield _products((word,), f"depends on the {word}, with its sign", (x, f"abs{x}"), (x, x, x))
        yield _products((word,), f"depends on the {word}, the same to both sides", (f"abs{x}",), (x, x))
    for x, y in itertools.combinations(motions, 2):
        words = (MOTIONS[x], MOTIONS[y])
        both = f"depends on {words[0]} and {words[1]} together"
        yield _products(words, f"{both}, with their sign", (x, x, y), (x, y, y))
        yield _products(words, f"{both}, by their product", (x, y))


def _products(words: tuple[str, ...], how: str, *products: tuple[str, ...]) -> Shape:
    names = [f"{{}}_{'_'.join(factors)}" for factors in products]
    terms: dict[str, Term] = {f"term_{n}": _product(f) for n, f in zip(names, products, strict=True)}
    return Shape(words, how, terms, tuple(names))


def _product(factors: Sequence[str]) -> Term:
    return lambda m, axis: m.unit(axis) * m.product(factors)


def _by_speed() -> Shape:
    terms: dict[str, Term] = {"{}_speed_1": lambda m, axis: m.speed, "{}_speed_2": lambda m, axis: m.speed**2}
    return Shape(("speed",), "depends on the speed", terms, ("{}_speed",))


def _by_place(side: str, first_m: float, span_m: float) -> Shape:
    name = f"{{}}_place_{side}"

    def along(m: Motion, count: int) -> np.ndarray:
        share = np.clip(((m.north if side == "north" else m.east) - first_m) / span_m, 0.0, 1.0)
        return np.cos(count * np.pi * share)

    terms: dict[str, Term] = {f"{name}_{k}": lambda m, axis, k=k: along(m, k) for k in range(1, WAVES_OF_PLACE + 1)}
    held = ((f"{name}_first", first_m), (f"{name}_span", span_m))
    return Shape((f"place to the {side}",), f"depends on the place to the {side}", terms, (name,), held)


def _by_past(x: str, time_s: float) -> Iterator[Shape]:
    """A force that follows a motion with a lag, alone and beside one that follows it at once."""
    name, word = f"{{}}_past_{x}", MOTIONS[x]

    def late(m: Motion, axis: str) -> np.ndarray:
        return m.unit(axis) * lagged(m.product((x,)), time_s, m.step_s)

    past: dict[str, Term] = {f"{name}_late@{time_s:.4g}": late}
    now: dict[str, Term] = {f"{name}_now@{time_s:.4g}": _product((x,))}
    held = ((f"{name}_now", 0.0), (f"{name}_time", time_s))
    how = f"depends on the past of the {word}, over {time_s:.3g} s"
    yield Shape((f"past of the {word}",), how, past, (name,), held)
    yield Shape((f"past of the {word}",), f"{how}, and on the {word} now", past | now, (name,), held)


def _in_time(longest_s: float, motions: Collection[str]) -> Iterator[Shape]:
    steady: dict[str, Term] = {"{}_first": lambda m, axis: np.ones(m.time_s.size)}
    growth: dict[str, Term] = {"{}_growth": lambda m, axis: m.past_s / longest_s}
    yield Shape(("time",), "grows through the record", growth)
    yield Shape(("time",), "changes evenly through the record", steady | growth)
    for x in motions:
        word = MOTIONS[x]
        yield Shape(("time", word), f"follows the {word}, by more and more through the record",
                    {f"{{}}_growth_{x}": _growing(_product((x,)), longest_s)})  # fmt: skip
    for begin in np.linspace(0.0, longest_s, STEPS + 2)[1:-1].tolist():
        yield Shape(("time",), f"begins {begin:.3g} s after the start of the record",
                    {f"{{}}_from_{begin:.4g}": _beginning(begin)})  # fmt: skip


def _growing(term: Term, longest_s: float) -> Term:
    return lambda m, axis: term(m, axis) * m.past_s / longest_s


def _beginning(begin_s: float) -> Term:
    return lambda m, axis: (m.past_s >= begin_s).astype(float)


def _periodic(period_s: float) -> Shape:
    omega, name = 2.0 * np.pi / period_s, f"{{}}_period_{period_s:.4g}"
    terms: dict[str, Term] = {
        f"{name}_cos": lambda m, axis: np.cos(omega * m.past_s),
        f"{name}_sin": lambda m, axis: np.sin(omega * m.past_s),
    }
    return Shape(("time",), f"swings with a period of {period_s:.3g} s", terms)


def _periods(length_s: float, longest_s: float, most: int) -> list[float]:
    """Periods, s, as close as records of this duration tell them apart; about as many as `most`."""
    low, high = 1.0 / (PERIODS[1] * length_s), 1.0 / (PERIODS[0] * length_s)
    step = max(0.5 / longest_s, (high - low) / most)
    return (1.0 / np.arange(max(low, 1.0 / longest_s), high, step)).tolist()


# ---- the bank
@dataclass(frozen=True)
class Forces:
    """Forces as candidates: id -> force; places and series of their numbers."""

    forces: Mapping[str, Force]
    candidates: tuple[Candidate, ...]
    places: Mapping[str, Place]
    series: Mapping[str, Series]


def forces_along(runs: FreeRuns) -> Forces:
    """Forces along the motions of the records, and drifts of the sensors that show them."""
    model, motions, length_s = runs.model, list(runs.motions.values()), runs.length_s
    units, longest_s = force_units(model, length_s), max(float(m.past_s[-1]) for m in motions)
    turned = float(np.ptp(np.concatenate([m.heading for m in motions])))
    steady = {name[-1]: (column, sd) for name, column, sd in forces_of(model)}
    forces: dict[str, Force] = {}
    candidates: list[Candidate] = []
    places: dict[str, Place] = {}
    series: dict[str, Series] = {}
    for shape in shapes(steady, length_s, longest_s, _places(motions), turned):
        for axis, (column, sd) in steady.items():
            force = Force(axis, shape)
            own = {name.format(axis): _on(axis, term) for name, term in shape.terms.items()}
            wide = WIDE * sd * units[axis]
            candidates.append(_candidate(force, {n: wide / _size(along, motions) for n, along in own.items()}))
            forces[force.id], series = force, series | own
            places |= {name: Place("term", (name,), column) for name in own}
    for symbol in (s for s in DRIFTS if s in runs.symbols):
        force = Force(symbol, Shape(("time",), "drifts through the record", {}))
        forces[force.id] = force
        unit = {"u": model.speed_m_s, "v": model.speed_m_s, "r": 1.0 / length_s, "psi": 1.0}[symbol]
        for own_places in _drifts(symbol, len(motions)):
            sds = {n: DRIFTS[symbol][1] * unit / (1.0 if p.column else longest_s) for n, p in own_places.items()}
            candidates.append(_candidate(force, sds))
            places |= own_places
    return Forces(forces, tuple(candidates), places, series)


def _places(motions: Sequence[Motion]) -> dict[str, tuple[float, float]]:
    """North, east -> first place and span of all records; nothing where a record measures no positions."""
    sides = {side: np.concatenate([getattr(m, side) for m in motions]) for side in ("north", "east")}
    return {side: (float(x.min()), float(np.ptp(x))) for side, x in sides.items() if np.ptp(x) > 0.0}


def _drifts(symbol: str, records: int) -> Iterator[dict[str, Place]]:
    """Numbers of a sensor's drift: from no error at the start of a record or from any, as in all records or in each."""
    for own in ((None,), range(records)) if records > 1 else ((None,),):
        for names in (("drift",), ("first", "drift")):
            yield {
                f"{symbol}_{name}" + ("" if r is None else f":{r}"): Place("drift", (symbol,), name == "first", r)
                for r in own
                for name in names
            }


def _on(axis: str, term: Term) -> Series:
    return lambda motion: term(motion, axis)


def _candidate(force: Force, sds: Mapping[str, float]) -> Candidate:
    """Shapes of the same variables on an axis are ways of one force."""
    of = f"{force.axis} by {' and '.join(force.shape.depends_on)}"
    return Candidate(force.id, tuple(Number(name, sd) for name, sd in sds.items()), FORCE, of=of)


def _size(along: Series, motions: Sequence[Motion]) -> float:
    """Root mean square of a force for a number of one."""
    return float(np.sqrt(np.mean(np.concatenate([along(m) for m in motions]) ** 2))) or 1.0
