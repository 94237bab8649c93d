"""The texts of manoeuvres: the part after the colon, read as numbers in SI units and written in a canonical form.

Each reader returns (values, canonical text) and raises ValueError with a short reason where the text is wrong.
"""

from __future__ import annotations

import math

from .grammar import ANGLE, DEGREE, TIME, pair, plain, positive

PERIOD = {"s": 1.0, "rad_s": 1.0}
RUDDER_MAX = 90.0 * DEGREE


def read_side(rest: str) -> tuple[int, str]:
    """First side (+1 starboard, -1 port) and the text without it; starboard where none is named."""
    for suffix, side in (("port", -1), ("starboard", 1)):
        if rest.endswith(":" + suffix):
            return side, rest[: -len(suffix) - 1]
    return 1, rest


def _angle(text: str, default: str | None = "deg") -> float:
    value = positive(text, ANGLE, default)
    if value > RUDDER_MAX:
        raise ValueError(f"{text!r} is above 90 deg")
    return value


def read_nothing(rest: str) -> tuple[tuple[float, ...], str]:
    """Nothing: a manoeuvre without numbers."""
    if rest:
        raise ValueError(f"nothing may follow, found {rest!r}")
    return (), ""


def read_pair(rest: str) -> tuple[tuple[float, ...], str]:
    """`RUDDER/HEADING` in degrees."""
    rudder, heading = pair(rest)
    values = _angle(rudder), _angle(heading)
    return values, "/".join(_degrees(v) for v in values)


def read_angle(rest: str) -> tuple[tuple[float, ...], str]:
    """`RUDDER` in degrees."""
    value = _angle(rest)
    return (value,), _degrees(value)


def read_pullout(rest: str) -> tuple[tuple[float, ...], str]:
    """`RUDDER[/HOLDs]`."""
    angle, _, hold = rest.partition("/")
    value = _angle(angle)
    if "/" not in rest:
        return (value,), _degrees(value)
    held = positive(hold, TIME)
    return (value, held), f"{_degrees(value)}/{plain(held)}s"


def read_spiral(rest: str) -> tuple[tuple[float, ...], str]:
    """`RUDDER[/STEP]` in degrees; STEP is a fifth of RUDDER by default and divides it."""
    angle, _, step = rest.partition("/")
    top = _angle(angle)
    if "/" not in rest:
        return (top, top / 5.0), _degrees(top)
    by = _angle(step)
    if abs(top / by - round(top / by)) > 1e-9:
        raise ValueError(f"the step {step!r} does not divide {angle!r}")
    return (top, by), f"{_degrees(top)}/{_degrees(by)}"


def read_tones(rest: str) -> tuple[tuple[float, ...], str]:
    """`AMPLITUDEdeg/PERIODs`, or a frequency with unit rad_s, joined by +: amplitude and rad/s of each sine."""
    values: list[float] = []
    texts = []
    for tone in rest.split("+"):
        amplitude, period = pair(tone)
        size, number = _angle(amplitude, None), positive(period, PERIOD)
        frequency = period.endswith("rad_s")
        values += [size, number if frequency else 2.0 * math.pi / number]
        texts.append(f"{_degrees(size)}deg/{plain(number)}{'rad_s' if frequency else 's'}")
    return tuple(values), "+".join(texts)


def read_clocked(rest: str) -> tuple[tuple[float, ...], str]:
    """`AMPLITUDEdeg/CLOCKs`."""
    angle, period = pair(rest)
    size, clock = _angle(angle, None), positive(period, TIME)
    return (size, clock), f"{_degrees(size)}deg/{plain(clock)}s"


def read_series(rest: str) -> tuple[tuple[float, ...], str]:
    """A rudder series, which has no text."""
    raise ValueError("a free series has no text form, make it with from_series()")


def _degrees(value: float) -> str:
    return plain(value / DEGREE)
