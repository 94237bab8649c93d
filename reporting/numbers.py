"""Numbers as text.  Every page, file and terminal table writes its numbers with these functions."""

from __future__ import annotations

import math
from collections.abc import Callable
from functools import partial
from typing import Any

MISSING = "–"
"""Stands where there is no value."""
DEG = math.degrees(1.0)
"""Degrees in a radian."""
LARGEST_FIXED, LARGEST_WHOLE = 1e5, 1e7
"""Numbers below the first are written without an exponent, whole numbers below the second in full."""


def is_missing(value: Any) -> bool:
    """Whether a value is None or nan."""
    return value is None or (isinstance(value, float) and math.isnan(value))


def number(value: Any, digits: int = 3) -> str:
    """A number with so many significant digits: `0.0123`, `1994`, `3.2e-9`, `inf`; a dash for None and nan.

    The minus sign is the one that programs read.
    """
    if is_missing(value):
        return MISSING
    value = float(value)
    if math.isinf(value):
        return "inf" if value > 0.0 else "-inf"
    if abs(value) < LARGEST_WHOLE and value == int(value):
        return str(int(value))
    if 10.0**digits <= abs(value) < LARGEST_FIXED:
        return f"{value:.0f}"
    mantissa, _, exponent = f"{value:.{digits}g}".partition("e")
    return f"{mantissa}e{int(exponent)}" if exponent else mantissa


SHORT = partial(number, digits=2)
"""A number with two significant digits."""


def with_unit(value: Any, unit: str, digits: int = 3) -> str:
    """`0.31 deg`; the unit `1` and an empty one are left out."""
    return number(value, digits) if unit in ("", "1") else f"{number(value, digits)} {unit}"


def fixed(value: Any, decimals: int) -> str:
    """A number with so many decimals; zero has no sign."""
    if is_missing(value) or math.isinf(value):
        return number(value)
    return f"{round(float(value), decimals) + 0.0:.{decimals}f}"


def percent(value: Any, decimals: int = 0) -> str:
    """A share as `97 %`."""
    return MISSING if is_missing(value) else f"{fixed(100.0 * float(value), decimals)} %"


def interval(value: Any, low: Any, high: Any, text: Callable[[Any], str] = number) -> str:
    """`0.31 [0.28, 0.34]`; the value alone where all three are missing or infinite."""
    middle, lower, upper = text(value), text(low), text(high)
    return middle if middle in (MISSING, "inf") and lower == middle else f"{middle} [{lower}, {upper}]"


def interval_digits(value: float, low: float, high: float, least: int = 2, most: int = 8) -> int:
    """Significant digits that show the width of an interval with two of them; 3 where it has no finite width."""
    width, largest = abs(high - low), max(abs(value), abs(low), abs(high))
    if not (math.isfinite(width) and math.isfinite(largest)) or width <= 0.0:
        return 3
    return min(max(2 + math.ceil(math.log10(largest / width)), least), most)


def r_squared(value: Any) -> str:
    """R^2 with three decimals; with two digits far below zero."""
    return fixed(value, 3) if is_missing(value) or float(value) > -10.0 else number(value, 2)


def p_value(value: float | None) -> str:
    """A p-value with three decimals, as a power of ten below 0.001."""
    if is_missing(value) or value is None:
        return MISSING
    return "< 1e-16" if value < 1e-16 else number(value, 2) if value < 1e-3 else fixed(value, 3)


def duration(seconds: Any) -> str:
    """A duration in s, ms, us or ns: `2.1 ms`."""
    if is_missing(seconds):
        return MISSING
    for size, unit in ((1.0, "s"), (1e-3, "ms"), (1e-6, "us")):
        if seconds >= size:
            return f"{number(seconds / size)} {unit}"
    return f"{number(seconds / 1e-9)} ns"
