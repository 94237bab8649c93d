"""Markdown text fitted to the width of a terminal: tables lose columns, nothing is wrapped inside a cell."""

from __future__ import annotations

import re
from collections.abc import Sequence
from itertools import groupby

NARROWEST = 8
"""Characters to which a cell is shortened at most."""
LEAST_COLUMNS = 3
"""Columns that are shortened before one of them is left out."""
CELLS = re.compile(r"(?<!\\)\|")


def fitted(text: str, width: int) -> str:
    """The text with no line longer than `width` characters, as far as words allow.

    Of a table as many of the first columns are shown as there is room for, and a line names the others; where not even
    `LEAST_COLUMNS` fit, their longest cells are shortened.  Other lines are wrapped between words.
    """
    parts = []
    for is_table, group in groupby(text.split("\n"), key=lambda line: line.startswith("|")):
        lines = list(group)
        parts += _table(lines, width) if is_table else [part for line in lines for part in _wrapped(line, width)]
    return "\n".join(parts)


def _wrapped(line: str, width: int) -> list[str]:
    from textwrap import wrap

    indent = " " * (len(line) - len(re.sub(r"\A\s*(?:[-*] |\d+\. )?", "", line)))
    found = wrap(line, width, subsequent_indent=indent, break_long_words=False, break_on_hyphens=False)
    return found if len(line) > width else [line]


def _table(lines: Sequence[str], width: int) -> list[str]:
    """The table's first columns that fit, and the names of the others."""
    if max(map(len, lines)) <= width:
        return list(lines)
    rows = [[cell.strip() for cell in CELLS.split(line)[1:-1]] for line in lines]
    names, right, rows = rows[0], [cell.endswith(":") for cell in rows[1]], [rows[0], *rows[2:]]
    widths = [max(3, *(len(row[j]) for row in rows)) for j in range(len(names))]
    count = _count(widths, width)
    sizes = _shortened(widths[:count], width)
    rule = ["-" * (size - 1) + ":" if end else "-" * size for size, end in zip(sizes, right, strict=False)]
    found = [_line(row[:count], sizes, right) for row in (rows[0], rule, *rows[1:])]
    left_out = ", ".join(names[count:])
    return [*found, *(["", *_wrapped(f"Not shown: {left_out}.", width)] if left_out else [])]


def _count(widths: Sequence[int], width: int) -> int:
    """How many of the first columns are shown."""
    fits = [n for n in range(1, len(widths) + 1) if _length(widths[:n]) <= width]
    short = [n for n in range(1, LEAST_COLUMNS + 1) if _length(_shortened(widths[:n], width)) <= width]
    return max([*fits, *short, 1])


def _length(widths: Sequence[int]) -> int:
    return sum(widths) + 3 * len(widths) + 1


def _shortened(widths: Sequence[int], width: int) -> list[int]:
    """Widths of columns, the widest made narrower until they fit, or none is wider than `NARROWEST`."""
    found = list(widths)
    while _length(found) > width and max(found) > NARROWEST:
        found[found.index(max(found))] -= 1
    return found


def _line(row: Sequence[str], widths: Sequence[int], right: Sequence[bool]) -> str:
    cut = [text if len(text) <= size else f"{text[: size - 1]}…" for text, size in zip(row, widths, strict=True)]
    cells = [text.rjust(size) if end else text.ljust(size) for text, size, end in zip(cut, widths, right, strict=False)]
    return f"| {' | '.join(cells)} |"
