"""What the numbers of a table can be: refused where no ship has them, warned of where hardly any has.

The ranges (`families/ranges.yaml`) are wide; every vessel of this package lies within the usual ones.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Mapping
from contextlib import suppress
from functools import lru_cache
from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from .errors import BadInput

if TYPE_CHECKING:
    from .model import Model

Numbers = Mapping[str, float]
SMALLEST, LARGEST = 1e-12, 1e16
"""Sizes of numbers other than 0 that mean anything in SI units or primes: 1e16 kg m2 is the inertia of no ship."""


class Range(NamedTuple):
    """What a number is when it is divided by a size of the ship, `of`: a key of `SIZES`, empty for 1.

    usual : outside, it is warned of;  possible : outside, it is refused;  sign : False where only its size counts.
    """

    name: str
    of: str
    usual: tuple[float, float]
    possible: tuple[float, float]
    sign: bool = True


class UnlikelyNumber(NamedTuple):
    """A number that is not as expected: its name, its value, what was expected, and whether no ship has it."""

    name: str
    value: float
    expected: str
    impossible: bool


def with_gyration(n: Numbers) -> dict[str, float]:
    """The numbers, of family mmg with `gyration`, the radius of gyration about the centre of gravity: m."""
    if not {"I_zz", "rho", "nabla", "x_G"} <= set(n) or not n["rho"] * n["nabla"] > 0.0:
        return dict(n)
    return {**n, "gyration": math.sqrt(max(n["I_zz"] / (n["rho"] * n["nabla"]) - n["x_G"] * n["x_G"], 0.0))}


SIZES: Mapping[str, Callable[[Numbers], float]] = {
    "": lambda n: 1.0,
    "L": lambda n: n["L"],
    "d": lambda n: n["d"],
    "L d": lambda n: n["L"] * n["d"],
    "L^2": lambda n: n["L"] ** 2,
    "L^3": lambda n: n["L"] ** 3,
    "L B d": lambda n: n["L"] * n["B"] * n["d"],
    "C_b L B d rho": lambda n: n["C_b"] * n["L"] * n["B"] * n["d"] * n["rho"],
    "m'": lambda n: n["m"] if "m" in n else 2.0 * n["nabla"] / (n["L"] ** 2 * n["d"]),
    "m22": lambda n: n["m22"],
}
ANY = 1e4
"""Size of an end of a range, or its ratio to the other end, from which the range says nothing of the number."""


@lru_cache(maxsize=1)
def _stated() -> dict[str, tuple[Range, ...]]:
    """Family -> ranges of its numbers (`families/ranges.yaml`)."""
    from .data_file import load

    found = {}
    for group in load(Path(__file__).parent / "families" / "ranges.yaml"):
        ranges = tuple(
            Range(name, of, (low, high), (least, most), not rest)
            for name, of, low, high, least, most, *rest in group["ranges"]
        )
        found |= dict.fromkeys(group["families"], ranges)
    return found


def ranges_of(family: str) -> tuple[Range, ...]:
    """What numbers of a family, or of one that extends it, are for ships; none where nothing is known."""
    return _stated().get(family.partition("+")[0], ())


NEAR = 1.2
"""Ratio of two statements of one speed up to which they may be rounded, or be two speeds of one trial."""
MASS = Range("mass", "C_b L B d rho", (0.97, 1.03), (0.8, 1.25))
"""Mass, kg, where a table has breadth and block coefficient beside it."""


class Scope(NamedTuple):
    """What a number may be, in its own unit: half of the range that most ships have, the ends of this range, wider by a
    quarter of it to each side, as far as any ship has it, and what is usual where a number is outside."""

    half_usual: float
    low: float
    high: float
    usual: float


def scopes(family: str, numbers: Numbers, speed_m_s: float) -> dict[str, Scope]:
    """Name -> scope, for those of the numbers whose range is known and says something: it ends below ANY, or below ANY
    times its smaller end; speed_m_s : that a model states beside the one of its coefficients."""
    by_name: dict[str, Scope] = {}
    numbers = with_gyration(numbers)
    for one in ranges_of(family):
        near, far = sorted(map(abs, one.usual))
        if one.name in numbers and one.sign and far < ANY * max(near, 1.0):
            with suppress(KeyError, ZeroDivisionError):  # the sizes that it is divided by are not among the numbers
                size = SIZES[one.of](numbers)
                (low, high), (least, most) = ([end * size for end in ends] for ends in (one.usual, one.possible))
                half = 0.5 * (high - low)
                ends = max(low - 0.5 * half, least), min(high + 0.5 * half, most)
                by_name.setdefault(one.name, Scope(half, *ends, low + half))
    if "gyration" in by_name:
        radius, mass = by_name["gyration"], numbers["rho"] * numbers["nabla"]
        low, high, usual = (mass * (r**2 + numbers["x_G"] ** 2) for r in (radius.low, radius.high, radius.usual))
        by_name["I_zz"] = Scope(0.5 * (high - low), low, high, usual)
    if "U0" in numbers and math.isfinite(speed_m_s):
        by_name["U0"] = _of_speed(speed_m_s)
    return by_name


def _of_speed(speed_m_s: float) -> Scope:
    """The scope of the speed that coefficients are for, of a model that states one beside it."""
    return Scope(0.5 * (NEAR - 1.0) * speed_m_s, speed_m_s / NEAR, NEAR * speed_m_s, speed_m_s)


def unusual_numbers(model: Model) -> list[str]:
    """What hardly any ship has of a model's numbers, and a rudder that turns it to the other side, a sentence each;
    nothing of a model without numbers."""
    if not model.known:
        return []
    names = (*model.coordinates, *model.constant_names)
    numbers = with_gyration(dict(zip(names, model.theta.tolist(), strict=True)))
    titles = {"gyration": "the radius of gyration, m, by I_zz"}
    said = [
        f"{titles.get(one.name, one.name)} of the model is {one.value:.4g}: {one.expected}"
        for one in doubts(numbers, ranges_of(model.family))
    ]
    speed, scope = numbers.get("U0", math.nan), _of_speed(model.speed_m_s)
    if math.isfinite(speed + scope.usual) and not scope.low < speed < scope.high:
        said.append(
            f"U0 of the model is {speed:.4g} m/s, and the speed that it states {scope.usual:.4g}: they are one speed"
        )
    side = side_of(model)
    if side not in (None, model.positive_rudder):
        said.append(
            f"a positive rudder angle turns the model to {side}, and the model says {model.positive_rudder}: its "
            "positive_rudder, or the signs of the rudder's terms, are likely wrong"
        )
    return said


def doubts(numbers: Numbers, ranges: Iterable[Range]) -> list[UnlikelyNumber]:
    """Every number outside its usual range, those that no ship has first."""
    size = f"{SMALLEST:g} to {LARGEST:g} is a size of a ship's world"
    absurd = [
        UnlikelyNumber(name, x, size, True) for name, x in numbers.items() if x and not SMALLEST <= abs(x) <= LARGEST
    ]
    if absurd:
        return absurd
    found = [doubt for one in ranges if one.name in numbers for doubt in _doubt(one, numbers)]
    return sorted(found, key=lambda doubt: not doubt.impossible)


def _doubt(one: Range, numbers: Numbers) -> list[UnlikelyNumber]:
    """Nothing, or what is doubtful about one number."""
    try:
        size = SIZES[one.of](numbers)
    except (KeyError, ZeroDivisionError):
        return []  # the table does not have it, or it is refused itself
    value = numbers[one.name] if one.sign else abs(numbers[one.name])
    if not size > 0.0 or _within(value / size, one.usual):
        return []
    low, high = one.usual
    share = f", {low:g} to {high:g} of {one.of}" if one.of else ""
    expected = f"{low * size:.3g} to {high * size:.3g} is usual{'' if one.sign else ' (without its sign)'}{share}"
    return [UnlikelyNumber(one.name, numbers[one.name], expected, not _within(value / size, one.possible))]


def _within(value: float, bounds: tuple[float, float]) -> bool:
    return bounds[0] <= value <= bounds[1]


def side_of(model: Model) -> str | None:
    """Side to which a small positive rudder angle turns the model from a straight course at first; None where its
    equations do not tell at once."""
    from .simulate import accelerations, initial_state, inputs_of

    start = np.nan_to_num(np.array(initial_state(model), float))
    if "u" in model.states and not start[model.states.index("u")] > 0.0:
        start[model.states.index("u")] = 1.0
    if "r" not in model.states or "delta" not in model.inputs:
        return None
    rates = [accelerations(model, start[None], inputs_of(model, [delta]))[0] for delta in (0.0, 0.01)]
    turn = float(rates[1][model.states.index("r")] - rates[0][model.states.index("r")])
    return None if turn == 0.0 or not math.isfinite(turn) else "starboard" if turn > 0.0 else "port"


def check_model(model: Model, file: object) -> None:
    """BadInput where the numbers give no finite coefficients, or a rudder that turns the ship to the other side."""
    if not (np.isfinite(model.coefficients).all() and np.isfinite(model.constants).all()):
        raise BadInput("the numbers give no finite coefficients", file=file, hint="check sizes and units")
    side = side_of(model)
    if side is not None and side != model.positive_rudder:
        said = f"a positive rudder angle of these numbers turns the ship to {side}, not to {model.positive_rudder}"
        raise BadInput(said, file=file, hint=f"give --positive-rudder {side}, or check the signs of the rudder's terms")
