"""Forces X, Y, N along the measured motion that no cause of the bank explains, as data: what they may follow.

Each is told as what it depends on.  It is a term of an extended model (`models.families.extensions`), and its numbers
are the parameters of that.
"""

from __future__ import annotations

import itertools
from collections.abc import Callable, Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from ...datasets.signals import lagged
from ...estimation.selection.number import Candidate, Number
from ...models.families.extensions import ANY_ORDER, PLACES, RESPONSE, extension_of, is_made_up, waves_of
from ..free_runs.bank import Place
from ..free_runs.motion import Motion
from ..free_runs.problem import SENSOR
from ..free_runs.units import scales
from .catalogue import FORCE, force_units, forces_of

if TYPE_CHECKING:
    from ...models.model import Model
    from ..free_runs.motion import Series
    from ..free_runs.problem import FreeRuns

AXES = {"X": "surge force", "Y": "sway force", "N": "yaw moment", "R": "yaw moment"}
UNITS = {"X": "N", "Y": "N", "N": "N m"}
BODY = {"R": "N"}
"""Axis of a response model -> that of the body, by which a force is told."""
WIDE = 5.0
"""Prior standard deviation of a force as a factor on that of a steady force of no cause."""
COUNTS = ("once", "twice", "three times", "four times")
MOTIONS = {"v": "drift", "r": "yaw rate", "d": "rudder angle"}
"""What forces follow; response models have no drift."""
LAGS = (0.25, 0.5, 1.0, 2.0, 4.0)
"""Times, in ship lengths sailed, that a force may lag behind the motion, at first."""
PERIODS = (0.5, 12.0)
"""Shortest and longest period, in ship lengths sailed."""
MOST_PERIODS = 360
"""Of all axes together."""
STEPS = 9
"""Times at which a force may begin, spread over the longest record."""
PLACES_TRIED = 7
"""Places beyond which a force may act, spread over the range of all records."""
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
    "apparent wind": ("wind on hull and superstructure, which the model lacks or has otherwise",
                      "sail the same manoeuvre with the wind from other sides, and in calm"),
    "place": ("a bank, shallow water, a lee, or a current that differs from place to place",
              "sail the same track the other way, and another track"),
    "past": ("memory of the flow, a slow steering gear, or a filter in the logger",
             "hold the rudder for long, and move it quickly, in turn"),
    "time": ("wind, current, waves, load or engine that changed, or a sensor that drifts",
             "repeat the same manoeuvre at another time"),
    "astern": ("propeller and rudder that act otherwise astern than ahead, which the model does not tell apart",
               "repeat the manoeuvre without going astern"),
    "event": ("a tug, a gust front, a lee, the wake of a passing ship, or shallow water for a while",
              "repeat the same manoeuvre at another time and place"),
}  # fmt: skip
"""Variable -> what a force that depends on it may be, and the manoeuvre that would tell."""

Term = Callable[[Motion, str], np.ndarray]
"""Force, N, or moment, N m, (N,) along a motion on an axis, for a number of one."""


Settings = tuple[float, ...]
"""Times of a shape that are no numbers of a fit: a lag, a period, when it begins and ends, s."""


@dataclass(frozen=True)
class Shape:
    """What a force follows.

    depends_on : variables, in words.  how : in a sentence, after the force's name.
    terms : number -> its force; `{}` in a name stands for the axis.
    extensions : of a family, that hold the numbers as parameters (whose names are the part before @); none where no
    model simulates it.
    held : further parameters of the extensions, with their values.
    settings : its times;  near : the shape at other ones;  steps : of these to the next that are tried.
    """

    depends_on: tuple[str, ...]
    how: str
    terms: Mapping[str, Term]
    extensions: tuple[str, ...] = ()
    held: tuple[tuple[str, float], ...] = ()
    settings: Settings = ()
    steps: Settings = ()
    near: Callable[[Settings], Shape] | None = None

    def neighbours(self, share: float) -> Iterator[Shape]:
        """The shapes at times that differ by a share of a step each."""
        if self.near is None:
            return
        for i, step in enumerate(self.steps):
            for change in (-share * step, share * step):
                moved = tuple(x + change if k == i else x for k, x in enumerate(self.settings))
                if all(x > 0.0 for x in moved):
                    yield replace(self.near(moved), steps=self.steps)


STEADY = Shape(("time",), "is steady", {"{}_steady": lambda motion, axis: np.ones(motion.time_s.size)})
"""What a force in time has to explain more than: known causes are steady."""


@dataclass(frozen=True)
class Force:
    """A shape on an axis X, Y or N; or the drift of the sensor of a state."""

    axis: str
    shape: Shape

    @property
    def id(self) -> str:
        """What tells it from all others."""
        return " ".join((self.axis, self.shape.how, *map(str, self.shape.settings)))

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

    @property
    def begins(self) -> bool:
        """Whether it begins at a time of every record, as manoeuvres that are alike do."""
        return any(name.endswith("_begin") for name in self.held)

    def parameters(self, values: Mapping[str, float]) -> Iterator[tuple[str, dict[str, float]]]:
        """Extensions with their parameters for values of the numbers."""
        known = self.held | {name.partition("@")[0]: value for name, value in values.items()}
        for extension in self.extensions:
            yield extension, {name: known[name] for name in extension_of(extension).units}

    def unit(self, name: str, model: Model) -> str:
        """Unit of one of its numbers in a model."""
        if self.axis not in AXES:
            first, growth = {"u": ("m/s", "m/s2"), "v": ("m/s", "m/s2"), "r": ("rad/s", "rad/s2"),
                             "psi": ("rad", "rad/s")}[self.axis]  # fmt: skip
            return first if "_first" in name else growth
        known = {n: unit for extension in self.extensions for n, unit in extension_of(extension).units.items()}
        own = name.partition("@")[0]
        if own.startswith(f"{self.axis}_wind_"):
            return f"{unit_of(self.axis, model)}/(m/s)2"
        if self.axis == RESPONSE and own.startswith("term_"):
            return _over_product(own.split("_")[2:], order_of(model))
        return known.get(own, unit_of(self.axis, model)).replace(ANY_ORDER, unit_of(self.axis, model))

    @property
    def held(self) -> dict[str, float]:
        """Further parameters of the extensions."""
        return {name.format(self.axis): value for name, value in self.shape.held}


def unit_of(axis: str, model: Model) -> str:
    """Unit of a force X, Y, N; of the yaw moment R of a response model, in the units of its highest derivative."""
    return f"rad/s{order_of(model)}" if axis == RESPONSE else UNITS[axis]


def order_of(model: Model) -> int:
    """Order, in time, of the highest derivative of the heading in a response model."""
    return 2 if model.states[0] == "r" else 3


def _over_product(factors: Sequence[str], order: int) -> str:
    """Unit of a yaw acceleration of an order over a product of yaw rates, rad/s, and rudder angles, rad."""
    angles = 1 - len(factors)
    times = order - sum(factor.endswith("r") for factor in factors)
    below = [f"{unit}{'' if n == 1 else n}" for unit, n in (("rad", -angles), ("s", times)) if n > 0]
    above = [f"{unit}{'' if n == 1 else n}" for unit, n in (("rad", angles), ("s", -times)) if n > 0]
    under = below[0] if len(below) == 1 else f"({' '.join(below)})"
    return (" ".join(above) or "1") + (f"/{under}" if below else "")


def reading_of(force: Force) -> tuple[str, str]:
    """What a force may be, and the manoeuvre that would tell."""
    if force.axis not in AXES:
        return "a sensor that warms up, or integrates an error", READINGS["time"][1]
    first = force.shape.depends_on[0]
    return READINGS[next(word for word in READINGS if first.startswith(word))]


def shapes(
    axes: Collection[str],
    length_s: float,
    longest_s: float,
    ranges: Mapping[str, tuple[float, float]],
    turned: float,
    windy: bool = False,
) -> list[Shape]:
    """Every shape on the axes of a model, for a ship that sails her length in length_s and records of at most
    longest_s.

    ranges : north, east [m], v, r (prime system), d [rad] -> the first value that is reached, and the span of all.
    turned : range of the headings, rad: of less than half a turn the records show a force that follows the turning.
    windy : whether the wind is measured.
    """
    motions, speed = [x for x in MOTIONS if x != "v" or "Y" in axes], "X" in axes
    return [
        *(_by_heading(count) for count in range(1, len(COUNTS) + 1) if turned >= np.pi),
        *_by_motion(motions),
        *([_by_speed()] if speed else []),
        *(_by_wind(how, parts) for how, parts in WINDS.items() if windy),
        *(_by_past(x, now, share * length_s) for x in motions for share in LAGS for now in (False, True)),
        *(_by_curve(x, *ranges[x]) for x in ranges if x in PLACES or x in motions),
        *(shape for x in ranges if x in PLACES for shape in _beyond_places(x, *ranges[x])),
        *_in_time(longest_s, motions),
        *itertools.starmap(_periodic, _periods(length_s, longest_s, MOST_PERIODS // len(axes))),
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


WINDS = {
    "goes with the apparent wind along the ship": ("ahead",),
    "goes with the apparent wind across the ship": ("across",),
    "depends on the apparent wind": ("ahead", "across", "both"),
}
"""How a force goes with the apparent wind, and the numbers of each."""


def _by_wind(how: str, parts: Collection[str]) -> Shape:
    """A force by the square of the apparent wind V from an angle gamma off the bow: V^2 cos gamma (ahead), V^2 sin
    gamma (across), V^2 sin 2 gamma / 2 (both), as series of wind coefficients begin (Isherwood 1972)."""
    every: dict[str, Term] = {
        "ahead": lambda m, axis: np.hypot(m.wind_ahead, m.wind_across) * m.wind_ahead,
        "across": lambda m, axis: np.hypot(m.wind_ahead, m.wind_across) * m.wind_across,
        "both": lambda m, axis: m.wind_ahead * m.wind_across,
    }
    return Shape(("apparent wind",), how, {f"{{}}_wind_{part}": every[part] for part in parts})


def _by_curve(x: str, first: float, span: float) -> Shape:
    """A smooth curve of a place, N or N m, or of a motion, in the prime system: cosines over its range."""
    name, word = f"{{}}_curve_{x}", f"place to the {x}" if x in PLACES else MOTIONS[x]

    def along(m: Motion, axis: str, count: int) -> np.ndarray:
        value = {"north": m.north, "east": m.east, "v": m.v, "r": m.r, "d": m.rudder}[x]
        wave = np.cos(count * np.pi * np.clip((value - first) / span, 0.0, 1.0))
        return wave if x in PLACES else m.unit(axis) * wave

    terms: dict[str, Term] = {f"{name}_{k}": lambda m, axis, k=k: along(m, axis, k) for k in range(1, waves_of(x) + 1)}
    held = ((f"{name}_first", first), (f"{name}_span", span))
    how = f"depends on the {word}" + ("" if x in PLACES else ", by a curve")
    return Shape((word,), how, terms, (name,), held)


def _beyond(x: str, first: float, step_m: float, numbers: Collection[str], settings: Settings) -> Shape:
    """A force beyond a place, which lies so far (settings) from the first one that is reached: of some numbers (first:
    everywhere; size; cos, sin: of the heading)."""
    place, name = first + settings[0], f"{{}}_beyond_{x}"

    def gate(m: Motion) -> np.ndarray:
        return (getattr(m, x) >= place).astype(float)

    every: dict[str, Term] = {
        "first": lambda m, axis: np.ones(m.time_s.size),
        "size": lambda m, axis: gate(m),
        "cos": lambda m, axis: gate(m) * np.cos(m.heading),
        "sin": lambda m, axis: gate(m) * np.sin(m.heading),
    }
    terms = {f"{name}_{n}" + ("" if n == "first" else f"@{place:.6g}"): every[n] for n in numbers}
    constants = ((f"{name}_place", place), *((f"{name}_{n}", 0.0) for n in every if n not in numbers))
    how, words = f"{'changes' if 'first' in numbers else 'acts'} {x} of {place:.3g} m", (f"place to the {x}",)
    if "cos" in numbers:
        how, words = f"{how} and goes with the heading", (*words, "heading")
    return Shape(words, how, terms, (name,), constants, settings, (step_m,),
                 lambda other: _beyond(x, first, step_m, numbers, other))  # fmt: skip


def _beyond_places(x: str, first: float, span: float) -> Iterator[Shape]:
    step_m = span / (PLACES_TRIED + 1)
    for along in (step_m * np.arange(1, PLACES_TRIED + 1)).tolist():
        for numbers in (("size",), ("first", "size"), ("size", "cos", "sin")):
            yield _beyond(x, first, step_m, numbers, (along,))


def _by_past(x: str, now: bool, time_s: float) -> Shape:
    """A force that follows a motion with a lag, alone or beside one that follows it at once: linear in the velocity
    (Cummins 1962)."""
    name, word = f"{{}}_past_{x}", MOTIONS[x]
    terms: dict[str, Term] = {f"{name}_late@{time_s:.6g}": lambda m, axis: lagged(m.own(x), time_s, m.step_s)}
    how = f"depends on the past of the {word}, over {time_s:.3g} s"
    if now:
        terms[f"{name}_now@{time_s:.6g}"] = lambda m, axis: m.own(x)
        how += f", and on the {word} now"
    held = ((f"{name}_now", 0.0), (f"{name}_time", time_s))
    return Shape((f"past of the {word}",), how, terms, (name,), held, (time_s,), (0.5 * time_s,),
                 lambda settings: _by_past(x, now, *settings))  # fmt: skip


def _in_time(longest_s: float, motions: Collection[str]) -> Iterator[Shape]:
    first: dict[str, Term] = {"{}_time_first": lambda m, axis: np.ones(m.time_s.size)}
    growth: dict[str, Term] = {"{}_time_growth": lambda m, axis: m.past_s}
    at_first = (("{}_time_first", 0.0),)
    yield Shape(("time",), "grows through the record", growth, ("{}_time",), at_first)
    yield Shape(("time",), "changes evenly through the record", first | growth, ("{}_time",))
    for x in motions:
        growing: dict[str, Term] = {f"{{}}_growth_{x}_size": lambda m, axis, x=x: m.own(x) * m.past_s}
        how = f"follows the {MOTIONS[x]}, by more and more through the record"
        yield Shape(("time", MOTIONS[x]), how, growing, (f"{{}}_growth_{x}",))
    step_s = longest_s / (STEPS + 1)
    for begin in (step_s * np.arange(1, STEPS + 1)).tolist():
        yield _begun((begin,), step_s)


def _begun(times_s: Settings, step_s: float) -> Shape:
    """A force that begins at a time of the record, and may end at another one."""
    begin, *end = times_s
    name = "{}_span" if end else "{}_from"
    label = "_".join(f"{t:.6g}" for t in times_s)

    def term(m: Motion, axis: str) -> np.ndarray:
        return ((m.past_s >= begin) & (m.past_s < (end[0] if end else np.inf))).astype(float)

    how = f"begins {begin:.3g} s after the start of the record" + "".join(f" and ends at {t:.3g} s" for t in end)
    held = tuple((f"{name}_{which}", t) for which, t in zip(("begin", "end"), times_s, strict=False))
    return Shape(("time",), how, {f"{name}_size@{label}": term}, (name,), held, times_s, (step_s,) * len(times_s),
                 lambda settings: _begun(settings, step_s))  # fmt: skip


def _periodic(period_s: float, step_s: float = 0.0) -> Shape:
    omega, name = 2.0 * np.pi / period_s, "{}_period"
    terms: dict[str, Term] = {
        f"{name}_cos@{period_s:.6g}": lambda m, axis: np.cos(omega * m.past_s),
        f"{name}_sin@{period_s:.6g}": lambda m, axis: np.sin(omega * m.past_s),
    }
    return Shape(("time",), f"swings with a period of {period_s:.3g} s", terms, (name,), ((f"{name}_time", period_s),),
                 (period_s,), (step_s,), lambda settings: _periodic(*settings))  # fmt: skip


def _periods(length_s: float, longest_s: float, most: int) -> list[tuple[float, float]]:
    """Periods, s, as close as records of this duration tell them apart, with the steps between them; about as many as
    `most`."""
    low, high = 1.0 / (PERIODS[1] * length_s), 1.0 / (PERIODS[0] * length_s)
    step = max(0.5 / longest_s, (high - low) / most)
    every = 1.0 / np.arange(max(low, 1.0 / longest_s), high, step)
    return [(p, step * p**2) for p in every.tolist()]


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
    longest_s = max(float(m.past_s[-1]) for m in motions)
    turned = float(np.ptp(np.concatenate([m.heading for m in motions])))
    steady = [name[-1] for name, *_ in forces_of(model)]
    forces: dict[str, Force] = {}
    candidates: list[Candidate] = []
    places: dict[str, Place] = {}
    series: dict[str, Series] = {}
    windy = all(np.isfinite(m.wind_ahead).all() for m in motions)
    for shape in shapes(steady, length_s, longest_s, _ranges(motions), turned, windy):
        for axis in steady:
            one = _as_candidate(runs, Force(axis, shape))
            forces |= one.forces
            candidates += one.candidates
            places |= one.places
            series |= one.series
    for symbol in (s for s in DRIFTS if s in runs.symbols):
        force = Force(symbol, Shape(("time",), "drifts through the record", {}))
        forces[force.id] = force
        unit = scales(model, length_s)[symbol]
        for own_places in _drifts(symbol, len(motions)):
            sds = {n: DRIFTS[symbol][1] * unit / (1.0 if p.column else longest_s) for n, p in own_places.items()}
            candidates.append(_candidate(force, sds))
            places |= own_places
    return Forces(forces, tuple(candidates), places, series)


def _as_candidate(runs: FreeRuns, force: Force) -> Forces:
    """One force as a candidate, with the places and series of its numbers."""
    motions = list(runs.motions.values())
    column, sd = next((column, sd) for name, column, sd in forces_of(runs.model) if name[-1] == force.axis)
    wide = WIDE * sd * force_units(runs.model, runs.length_s)[force.axis]
    own = {name.format(force.axis): _on(force.axis, term) for name, term in force.shape.terms.items()}
    candidate = _candidate(force, {n: wide / _size(along, motions) for n, along in own.items()})
    return Forces({force.id: force}, (candidate,), {n: Place("term", (n,), column) for n in own}, own)


def with_force(runs: FreeRuns, forces: Forces, force: Force) -> tuple[FreeRuns, Forces, Candidate]:
    """The runs and forces with one more, and its candidate."""
    one = _as_candidate(runs, force)
    both = Forces(
        {**forces.forces, **one.forces}, (*forces.candidates, *one.candidates),
        {**forces.places, **one.places}, {**forces.series, **one.series},
    )  # fmt: skip
    return runs.with_numbers(one.places, one.series), both, one.candidates[0]


def with_spans(runs: FreeRuns, forces: Forces, spans: Sequence[tuple[str, float, float]]) -> tuple[FreeRuns, Forces]:
    """The runs and forces with steady forces over spans of time (axis, begin and end, s) of all records."""
    step_s = max(float(m.past_s[-1]) for m in runs.motions.values()) / (STEPS + 1)
    for axis, begin, end in spans:
        times = tuple(t for t in (begin, end) if np.isfinite(t))
        runs, forces, _ = with_force(runs, forces, Force(axis, _begun(times, step_s)))
    return runs, forces


def drift_of(places: Mapping[str, Place], candidate: Candidate) -> dict[str, str]:
    """Number -> instrument of a model, of a sensor that drifts alike in all records; none of any other candidate."""
    own = {name: places[name] for name in candidate.names}
    if any(place.kind != "drift" or place.record is not None for place in own.values()):
        return {}
    return {n: f"{SENSOR[p.entries[0]]}_{'bias' if p.column else 'drift'}" for n, p in own.items()}


def _ranges(motions: Sequence[Motion]) -> dict[str, tuple[float, float]]:
    """North, east, v', r' and rudder angle -> first value and span of all records; nothing where a record measures
    none."""
    fields = {"north": "north", "east": "east", "v": "v", "r": "r", "d": "rudder"}
    values = {x: np.concatenate([getattr(m, field) for m in motions]) for x, field in fields.items()}
    return {x: (float(y.min()), float(np.ptp(y))) for x, y in values.items() if np.ptp(y) > 0.0}


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
