"""Numbers as somebody types them: decimals of ASCII digits, and nothing else that `float` and `int` would take."""

from __future__ import annotations

import math
import re

DECIMAL = r"[+-]?(?:\d++\.?\d*+|\.\d++)(?:[eE][+-]?\d++)?"
"""A number with a decimal point; no part of it is tried twice, however long the text."""
_DECIMAL, _WHOLE = re.compile(DECIMAL, re.ASCII), re.compile(r"[+-]?\d++", re.ASCII)
MOST_DIGITS = 18
"""Digits of a whole number."""


def number_of(text: str) -> float:
    """The number that a text states; ValueError, with a short reason, where it is no decimal (`1_0`, `nan`, `1 kg`,
    digits of other scripts) or a double cannot hold it (`1e99999`, `1e-99999`)."""
    if not _DECIMAL.fullmatch(text):
        raise ValueError(f"{_short(text)} is not a number such as 12, -0.5 or 1e-3")
    value = float(text)
    if not math.isfinite(value):
        raise ValueError(f"the number {text[:40]} is too large")
    if value == 0.0 and re.search("[1-9]", re.split("[eE]", text)[0]):
        raise ValueError(f"the number {text[:40]} is too small")
    return value


def whole_of(text: str) -> int:
    """The whole number that a text states; ValueError, with a short reason, where it is none or has too many digits."""
    if not _WHOLE.fullmatch(text):
        raise ValueError(f"{_short(text)} is not a whole number such as 12")
    count = len(text.lstrip("+-"))
    if count > MOST_DIGITS:
        raise ValueError(f"a number of {count} digits, at most {MOST_DIGITS} are read")
    return int(text)


def _short(text: str) -> str:
    return repr(text if len(text) <= 40 else f"{text[:37]}...")
