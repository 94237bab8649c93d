"""The smallest value of a function of one number between bounds.

Parabolas through the three best points, with golden sections where these lead nowhere: Brent 1973, Algorithms for
Minimization without Derivatives, ch 5.  `scipy.optimize` takes the same steps, but a third of a second to import.
"""

from __future__ import annotations

from collections.abc import Callable
from math import sqrt
from typing import NamedTuple

GOLDEN = 0.5 * (3.0 - sqrt(5.0))
ROUNDING = sqrt(2.2e-16)
"""Relative accuracy that rounding leaves to the place of a minimum."""


class Tried(NamedTuple):
    """A point and the function's value there."""

    x: float
    value: float


def bounded_minimum(
    function: Callable[[float], float], low: float, high: float, accuracy: float, most: int = 500
) -> Tried:
    """The best point that is found between low and high, to within `accuracy`, by at most `most` calls."""
    x = low + GOLDEN * (high - low)
    best = second = third = Tried(x, function(x))
    step = before = 0.0
    for _ in range(most - 1):
        least = ROUNDING * abs(best.x) + accuracy / 3.0
        if not abs(best.x - 0.5 * (low + high)) > 2.0 * least - 0.5 * (high - low):
            break
        step, before = _step(low, high, (best, second, third), step, before, least)
        x = best.x + max(abs(step), least) * (1.0 if step >= 0.0 else -1.0)
        new = Tried(x, function(x))
        if new.value <= best.value:
            low, high = (best.x, high) if x >= best.x else (low, best.x)
            best, second, third = new, best, second
        else:
            low, high = (x, high) if x < best.x else (low, x)
            if new.value <= second.value or second.x == best.x:
                second, third = new, second
            elif new.value <= third.value or third.x in (best.x, second.x):
                third = new
    return best


def _step(
    low: float, high: float, tried: tuple[Tried, Tried, Tried], step: float, before: float, least: float
) -> tuple[float, float]:
    """The next step from the best of the points, and the one that it is to be compared with.

    step, before : the last one, and the one before it; least : size of the smallest step.
    """
    best, second, third = tried
    middle = 0.5 * (low + high)
    if abs(before) > least:
        r = (best.x - second.x) * (best.value - third.value)
        q = (best.x - third.x) * (best.value - second.value)
        p = (best.x - third.x) * q - (best.x - second.x) * r
        q = 2.0 * (q - r)
        p, q = -p if q > 0.0 else p, abs(q)
        if abs(p) < abs(0.5 * q * before) and q * (low - best.x) < p < q * (high - best.x):
            x = best.x + p / q
            if x - low < 2.0 * least or high - x < 2.0 * least:
                return least if middle >= best.x else -least, step
            return p / q, step
    before = low - best.x if best.x >= middle else high - best.x
    return GOLDEN * before, before
