"""Dates with times of day that all have the same length, such as 2024-05-03T08:00:00.100Z, column by column."""

from __future__ import annotations

import numpy as np

from .cell_texts import Texts

FORM = "0000-00-00T00:00:00"
"""Digits and signs of a moment in full seconds; a space may stand for the T, and decimals and a Z follow."""
MOST_DECIMALS = 9


def even_stamps(texts: Texts) -> np.ndarray | None:
    """Seconds since 1970 (N,) of moments in UTC or without a zone; None where a text is of another form or no moment,
    or the texts are not Arrow's."""
    signs = texts.characters(len(FORM) + MOST_DECIMALS + 2) if texts.arrow is not None else None
    if signs is None or signs.shape[1] < len(FORM):
        return None
    zoned = bool(signs[0, -1] == ord("Z"))
    decimals = signs.shape[1] - len(FORM) - 1 - zoned
    if not 0 < decimals <= MOST_DECIMALS and decimals != -1:
        return None
    form = FORM + ("" if decimals < 0 else "." + "0" * decimals) + "Z" * zoned
    digit = np.array([sign == "0" for sign in form])
    wanted = np.frombuffer(form.replace("T", chr(signs[0, 10])).encode(), np.uint8)
    if chr(signs[0, 10]) not in "T " or (signs[:, ~digit] != wanted[~digit]).any():
        return None
    numbers = signs - np.uint8(ord("0"))
    if (numbers[:, digit] > 9).any():
        return None
    return _seconds([_whole(numbers[:, a:b]) for a, b in ((0, 4), (5, 7), (8, 10), (11, 13), (14, 16), (17, 19))],
                    _whole(numbers[:, 20 : 20 + decimals]) * 10 ** (9 - max(decimals, 0)))  # fmt: skip


def _whole(digits: np.ndarray) -> np.ndarray:
    """Whole numbers (N,) of their digits (N, k)."""
    found = np.zeros(len(digits), np.int64)
    for digit in digits.T:
        found = 10 * found + digit
    return found


def _seconds(parts: list[np.ndarray], nanoseconds: np.ndarray) -> np.ndarray | None:
    """Seconds since 1970 (N,) of year, month, day, hour, minute and second; None where they are no moment, or one of
    other centuries."""
    year, month, day, hour, minute, second = parts
    if (year < 1700).any() or (year > 2200).any() or (month < 1).any() or (month > 12).any() or (day < 1).any():
        return None
    if (hour > 23).any() or (minute > 59).any() or (second > 59).any():
        return None
    first = (12 * (year - 1970) + month - 1).astype("datetime64[M]")
    days = first.astype("datetime64[D]").astype(np.int64) + day - 1
    if (day > 28).any() and (days.astype("datetime64[D]").astype("datetime64[M]") != first).any():
        return None
    return 86400 * days + 3600 * hour + 60 * minute + second + nanoseconds / 1e9
