"""The small strict grammar that manoeuvre, disturbance and noise strings share: numbers with units."""

from __future__ import annotations

import math
import re
from collections.abc import Mapping

from ..models.number_texts import DECIMAL, number_of

DEGREE = math.pi / 180.0
KNOT = 1852.0 / 3600.0

ANGLE = {"deg": DEGREE, "rad": 1.0}
TIME = {"s": 1.0}
SHARE = {"%": 0.01}
SMALLEST, LARGEST = 1e-12, 1e9
"""Numbers other than 0 in SI units and radians (degrees where the grammar has them) that are taken."""

_QUANTITY = re.compile(rf"({DECIMAL})([A-Za-z%][A-Za-z_%]*)?", re.ASCII)


def quantity(text: str, units: Mapping[str, float], default: str | None = None) -> float:
    """Read ``20deg`` and return it times ``units["deg"]``.

    ``default`` names the unit of a number without unit; without it the unit must be written.
    Raises ValueError with a short reason.
    """
    match = _QUANTITY.fullmatch(text)
    if match is None:
        raise ValueError(f"{text!r} is not a number with the unit {' or '.join(units)}")
    unit = match.group(2) or default
    if unit is None:
        raise ValueError(f"{text!r} lacks its unit ({' or '.join(units)})")
    if unit not in units:
        raise ValueError(f"{text!r} has an unknown unit (expected {' or '.join(units)})")
    value = number_of(match.group(1)) * units[unit]
    if value and not SMALLEST <= abs(value) <= LARGEST:
        raise ValueError(f"{text!r} is no size of a ship's world ({SMALLEST:g} to {LARGEST:g})")
    return value


def positive(text: str, units: Mapping[str, float], default: str | None = None) -> float:
    """A quantity that must be above zero; ValueError otherwise."""
    value = quantity(text, units, default)
    if value <= 0.0:
        raise ValueError(f"{text!r} must be above 0")
    return value


def share(text: str) -> float:
    """A percentage as a fraction: ``5%`` is 0.05; ValueError outside 0..100 %."""
    value = quantity(text, SHARE)
    if not 0.0 <= value <= 1.0:
        raise ValueError(f"{text!r} must lie between 0% and 100%")
    return value


def pair(text: str) -> tuple[str, str]:
    """Split ``a/b``; ValueError if there is not exactly one slash."""
    parts = text.split("/")
    if len(parts) != 2:
        raise ValueError(f"{text!r} needs exactly one '/'")
    return parts[0], parts[1]


def plain(value: float) -> str:
    """Shortest text that keeps a number given by hand: ``20``, ``2.5``, ``0.27``."""
    return f"{value:.15g}"
