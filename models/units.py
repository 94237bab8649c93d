"""Units of numbers in data files, converted to the SI units and radians that are used inside."""

from __future__ import annotations

import math

DEGREE = math.pi / 180.0
FACTORS = {
    "rad": {"deg": DEGREE},
    "rad/s": {"deg/s": DEGREE},
    "m/s": {"kn": 1852.0 / 3600.0, "km/h": 1.0 / 3.6},
    "m": {"km": 1e3},
    "s": {"ms": 1e-3, "min": 60.0},
    "1/s": {"rps": 1.0, "rpm": 1.0 / 60.0},
    "1": {"%": 0.01},
    "N": {"kN": 1e3},
    "kg": {"t": 1e3},
}
"""Unit inside -> units that are converted to it, and by which factor."""


def factor(unit: str, needed: str) -> float:
    """What a number in `unit` is multiplied by to be one in `needed`; ValueError where it cannot be one."""
    if unit == needed:
        return 1.0
    known = FACTORS.get(needed, {})
    if unit not in known:
        also = f" (or {', '.join(known)})" if known else ""
        raise ValueError(f"the unit is {unit!r} where {needed!r}{also} is needed")
    return known[unit]


def si_factor(unit: str) -> float:
    """What a number in `unit` is multiplied by to be one in SI units and radians; 1 for units not listed here."""
    return next((known[unit] for known in FACTORS.values() if unit in known), 1.0)
