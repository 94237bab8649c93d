"""Text in columns of fixed width, as Fortran writes it: exponents with D, numbers that touch, names with spaces."""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Sequence

from .cells import is_number

EXPONENT = re.compile(r"(?<=[\d.])[dD](?=[-+]?\d{2,3}(?![\w.]))")
NUMBER = r"\d*\.\d+(?:[EeDd][-+]?\d{2,3})?"
TOUCHING = re.compile(rf"((?:(?<![\d.A-Za-z])|(?=-))[-+]?{NUMBER})(?=-{NUMBER}(?![\d.]))")
"""A number that ends where the sign of the next one stands."""
TOKEN = re.compile(r"\S+")
QUOTED = re.compile(r'"[^"]*"')
ALIGNED = 0.4
"""Share of the lines in which a number ends where the others of its column do; those that were cut apart are longer."""


def with_exponents(text: str, sample: Sequence[str]) -> str:
    """The text with E for the exponents that Fortran writes with D, where the sample has some."""
    if not any(EXPONENT.search(line) for line in sample):
        return text
    return EXPONENT.sub("E", text)


def with_spaces(text: str, sample: Sequence[str]) -> str:
    """The text, separated by spaces, with a space between numbers that touch, where the sample has some."""
    return TOUCHING.sub(r"\1 ", text) if any(TOUCHING.search(line) for line in sample) else text


def column_ends(lines: Sequence[str]) -> list[int] | None:
    """Where the columns of lines end that are separated by spaces; None where they do not end at the same places."""
    rows = [[match.end() for match in TOKEN.finditer(line)] for line in lines]
    counts = Counter(len(row) for row in rows if len(row) > 1)
    if not counts:
        return None
    width = counts.most_common(1)[0][0]
    usual = [row for row in rows if len(row) == width]
    ends = [Counter(column).most_common(1)[0] for column in zip(*usual, strict=True)]
    return [end for end, _ in ends] if all(often >= ALIGNED * len(usual) for _, often in ends) else None


def header_cells(line: str, width: int, ends: Sequence[int] | None) -> tuple[str, ...] | None:
    """The names of a header line that has spaces within them; None where it is cut well by spaces, or not at all.

    Names are apart by two spaces or more, or end where the columns do.
    """
    plain = line.strip()
    quoted = QUOTED.findall(plain)
    if len(quoted) == width and not QUOTED.sub("", plain).strip("() \t"):
        return tuple(text.strip('"') for text in quoted)
    if len(plain.split()) <= width or any(map(is_number, plain.split())):
        return None
    wide = re.split(r"\s{2,}|\t", plain)
    if len(wide) == width:
        return tuple(wide)
    if ends is None or any(
        line[end - 1 : end + 1].strip() and len(line[end - 1 : end + 1].split()[0]) > 1 for end in ends
    ):
        return None
    starts = [0, *ends[:-1]]
    cells = [line[a:b].strip() for a, b in zip(starts, [*ends[:-1], len(line)], strict=True)]
    return tuple(cells) if all(cells) else None
