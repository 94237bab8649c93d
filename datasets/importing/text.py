"""Text logs: encoding and separator are found, lines are split into cells."""

from __future__ import annotations

import csv
import re
from collections import Counter
from collections.abc import Sequence
from pathlib import Path

from ...models.errors import BadInput
from .layout import SAMPLE, Line, is_value, table_of
from .raw import RawTable

MARKS = ((b"\xff\xfe", "utf-16"), (b"\xfe\xff", "utf-16"), (b"\xef\xbb\xbf", "utf-8-sig"))
OTHER_SCRIPTS = ("cp932", "shift", "euc", "gb", "big5", "hz", "iso2022", "johab", "cp949", "cp1251", "koi8", "cp1253")
"""Encodings of scripts that Windows-1252 does not hold; those of Latin letters are hardly told from it."""
COMMENT = re.compile(r"^\s*(#|%|//|!|\*|;(?=\s*[A-Za-z#]))+\s?")
SEPARATORS = {";": "semicolons", "\t": "tabs", "|": "bars", ",": "commas", " ": "spaces"}
SPACES = 0.8
"""Weight of spaces: dates with times of day hold some, too."""
UNQUOTED = re.compile(r"-?\d+,\d+(,-?\d+,\d+)+")


def decoded(data: bytes, path: Path) -> tuple[str, str]:
    """(text, its encoding): UTF-8, UTF-16, the likely one of another script, or else Windows-1252; BadInput where
    the file is no text."""
    encoding = next((name for mark, name in MARKS if data.startswith(mark)), None) or _unmarked(data[:4096])
    if encoding is None:
        try:
            return data.decode("utf-8"), "utf-8"
        except UnicodeDecodeError:
            encoding = _unstated(data)
    if b"\0" in data and not encoding.startswith("utf-16"):
        hint = "export it as CSV, xlsx, MAT (version 7 or earlier) or NMEA 0183"
        raise BadInput("a binary file of unknown kind", file=path, hint=hint)
    try:
        return data.decode(encoding, errors="strict" if encoding.startswith("utf") else "replace"), encoding
    except UnicodeDecodeError:
        raise BadInput(f"starts as {encoding} text but is damaged", file=path, hint="export it again") from None


def _unstated(data: bytes) -> str:
    """The likely encoding of text that is not UTF-8, by charset-normalizer from the lines that are not ASCII."""
    from charset_normalizer import from_bytes

    lines = [line for line in data[:1_000_000].splitlines() if not line.isascii()][:50]
    best = from_bytes(b"\n".join(line[:2000] for line in lines)).best()
    return best.encoding if best is not None and best.encoding.startswith(OTHER_SCRIPTS) else "cp1252"


def _unmarked(head: bytes) -> str | None:
    """The form of UTF-16 without a mark, told by zeros in every other byte."""
    even, odd = head[0::2].count(0), head[1::2].count(0)
    if len(head) > 20 and odd > 0.4 * len(head) / 2 and even == 0:
        return "utf-16-le"
    return "utf-16-be" if len(head) > 20 and even > 0.4 * len(head) / 2 and odd == 0 else None


def read_text(text: str, encoding: str, path: Path) -> RawTable:
    """The table of a text log.

    Raises
    ------
    BadInput : no line holds data, or decimal commas stand between commas.
    """
    raw = [(i, line) for i, line in enumerate(text.splitlines(), start=1) if line.strip()]
    if not raw:
        raise BadInput("the file is empty", file=path)
    sample = [line for _, line in raw if not COMMENT.match(line)][: 2 * SAMPLE]
    _refuse_two_commas(sample, path)
    separator = find_separator(sample)
    lines = [_line(number, line, separator) for number, line in raw]
    done = [f"{encoding} text, separated by {SEPARATORS[separator]}"]
    table = table_of(_without_trailing(lines), path.name, "", done)
    if table is None:
        hint = "a log needs a header and rows of numbers"
        raise BadInput("no rows of numbers found", file=path, hint=hint)
    return table


def find_separator(lines: Sequence[str]) -> str:
    """The separator that cuts most lines into equally many cells that are values."""
    scores = {separator: _score(lines[-SAMPLE:], separator) for separator in SEPARATORS}
    return max(scores, key=lambda separator: scores[separator])


def _score(lines: Sequence[str], separator: str) -> float:
    """Share of the lines with the commonest number of cells, times the share of their cells that are values."""
    rows = [_cells(line, separator) for line in lines]
    counts = Counter(len(row) for row in rows if len(row) > 1)
    if not counts:
        return 0.0
    width, often = counts.most_common(1)[0]
    cells = [cell for row in rows if len(row) == width for cell in row]
    values = sum(map(is_value, cells)) / len(cells)
    filled = sum(bool(cell.strip()) for cell in cells) / len(cells)
    weight = SPACES if separator == " " else 1.0
    return weight * often / max(len(rows), 1) * values * (0.5 + 0.5 * filled)


def _cells(line: str, separator: str) -> list[str]:
    if separator == " ":
        return line.split()
    if '"' not in line:
        return line.split(separator)
    return next(csv.reader([line], delimiter=separator, skipinitialspace=True), [])


def _line(number: int, text: str, separator: str) -> Line:
    mark = COMMENT.match(text)
    return Line(number, tuple(_cells(text[mark.end() :] if mark else text, separator)), mark is not None)


def _without_trailing(lines: Sequence[Line]) -> list[Line]:
    """The lines without the empty cell that a separator at the end of every line makes."""
    plain = [line for line in lines if not line.comment and len(line.cells) > 2]
    if not plain or sum(not line.cells[-1].strip() for line in plain) < 0.9 * len(plain):
        return list(lines)
    width = Counter(len(line.cells) for line in plain).most_common(1)[0][0]
    if any(line.cells[-1].strip() for line in plain if len(line.cells) == width):
        return list(lines)
    return [Line(x.number, x.cells[:-1], x.comment) if len(x.cells) == width else x for x in lines]


def _refuse_two_commas(lines: Sequence[str], path: Path) -> None:
    """Refuse decimal commas that cannot be told from the commas between columns."""
    body = lines[-SAMPLE:]
    header = next((line for line in lines if re.search(r"[A-Za-z]{2}", line)), "")
    width = header.count(",") + 1
    if (
        width > 1
        and ";" not in header
        and sum(bool(UNQUOTED.fullmatch(line.strip())) for line in body) > 0.5 * len(body)
    ):
        counts = Counter(line.count(",") + 1 for line in body)
        if counts.most_common(1)[0][0] > width:
            hint = "export it with semicolons or tabs between the columns, or with decimal points"
            raise BadInput("decimal commas cannot be told from the commas between columns", file=path, hint=hint)
