"""Text logs: encoding and separator are found, lines are split into cells."""

from __future__ import annotations

import csv
import itertools
import re
from collections import Counter
from collections.abc import Iterable, Iterator, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from ...models.errors import BadInput
from ..arrow_csv import FEWEST_BYTES, arrow
from .cells import GAPS, Texts, is_number
from .layout import (
    LONGEST,
    SAMPLE,
    DataRows,
    Layout,
    Line,
    PlainRows,
    is_data,
    is_header_again,
    is_value,
    of_other_width,
    table_of,
)
from .raw import RawTable

MARKS = ((b"\xff\xfe", "utf-16"), (b"\xfe\xff", "utf-16"), (b"\xef\xbb\xbf", "utf-8-sig"))
OTHER_SCRIPTS = ("cp932", "shift", "euc", "gb", "big5", "hz", "iso2022", "johab", "cp949", "cp1251", "koi8", "cp1253")
"""Encodings of scripts that Windows-1252 does not hold; those of Latin letters are hardly told from it."""
ASCII, SIGNS = bytes(range(128)), {0xB0, 0xB1, 0xB2, 0xB3, 0xB4, 0xB5, 0xB7, 0xBA, 0x92, 0x96, 0x97, 0xA0}
"""The bytes of ASCII, and others that are signs in Windows-1252: degree, plus-minus, powers, micro, dashes."""
COMMENT = re.compile(r"^\s*(#|%|//|!|\*|;(?=\s*[A-Za-z#]))+\s?")
SEPARATORS = {";": "semicolons", "\t": "tabs", "|": "bars", ",": "commas", " ": "spaces"}
MOST_COLUMNS = 2000
"""Columns of a table that are read."""
SPACES = 0.8
"""Weight of spaces: dates with times of day hold some, too."""
FIRST_LINES, HEAD, MOST_BREAKS = 5000, 100_000, 5
"""Lines that are looked at; characters within which quoted cells may hold line breaks, and how many."""
UNQUOTED = re.compile(r"-?\d+,\d+(,-?\d+,\d+)+")


def decoded(data: bytes, path: Path) -> tuple[str, str]:
    """(text, its encoding): UTF-8, UTF-16, the likely one of another script, or else Windows-1252; BadInput where
    the file is no text."""
    encoding = next((name for mark, name in MARKS if data.startswith(mark)), None)
    head = data[:4096]
    even, odd = head[0::2].count(0), head[1::2].count(0)
    if encoding is None and len(head) > 20 and max(even, odd) > 0.4 * len(head) / 2 and min(even, odd) == 0:
        encoding = "utf-16-le" if even == 0 else "utf-16-be"  # without a mark: zeros in every other byte
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

    if set(data.translate(None, ASCII)) <= SIGNS:  # behind one sign a letter of a script may seem to stand
        return "cp1252"
    lines = [line for line in data[:1_000_000].splitlines() if not line.isascii()][:50]
    best = from_bytes(b"\n".join(line[:2000] for line in lines)).best()
    return best.encoding if best is not None and best.encoding.startswith(OTHER_SCRIPTS) else "cp1252"


def usual_width(widths: Iterable[int]) -> int:
    """The commonest number of cells."""
    return Counter(widths).most_common(1)[0][0]


def read_text(text: str, encoding: str, path: Path) -> RawTable:
    """The table of a text log.

    Raises
    ------
    BadInput : no line holds data, or decimal commas stand between commas.
    """
    if text.count("\r") != text.count("\r\n"):  # lines that end as on old machines
        text = text.replace("\r\n", "\n").replace("\r", "\n")
    sample = [(number, _bounded(number, line, path)) for number, line in _sample(text)]
    if not sample:
        raise BadInput("the file is empty", file=path)
    plain = [line for _, line in sample if not COMMENT.match(line)]
    head, body = plain[: 2 * SAMPLE], plain[: 2 * SAMPLE][-SAMPLE:]
    header = next((line for line in head if re.search(r"[A-Za-z]{2}", line)), "")
    width = header.count(",") + 1
    numbers = sum(UNQUOTED.fullmatch(line.strip()) is not None for line in body)
    commas = width > 1 and ";" not in header and numbers > 0.5 * len(body)
    if commas and usual_width(line.count(",") + 1 for line in body) > width:
        hint = "export it with semicolons or tabs between the columns, or with decimal points"
        raise BadInput("decimal commas cannot be told from the commas between columns", file=path, hint=hint)
    # exponents that Fortran writes with D, and numbers that touch
    tidy = EXPONENT.sub("E", text) if any(map(EXPONENT.search, plain[:SAMPLE])) else text
    body = [EXPONENT.sub("E", line) for line in plain[: 2 * SAMPLE]][-SAMPLE:]
    separator = max(SEPARATORS, key=lambda separator: _score(body, separator))
    if separator == " " and any(map(TOUCHING.search, plain[:SAMPLE])):
        tidy = TOUCHING.sub(r"\1 ", tidy)
    if tidy is not text:
        text, sample = tidy, [(number, _bounded(number, line, path)) for number, line in _sample(tidy)]
    full = usual_width(line.count(separator) + 1 for line in body) if body else 0
    rows = [_line(number, line, separator, full) for number, line in sample]
    rows = _with_names(rows, sample) if separator == " " else rows
    # a separator at the end of every line makes an empty cell there
    long = [row for row in rows if not row.comment and len(row.cells) > 2]
    width = usual_width(len(row.cells) for row in long) if long else None
    trailed = [not row.cells[-1].strip() for row in long]
    if sum(trailed) < 0.9 * len(long) or any(row.cells[-1].strip() for row in long if len(row.cells) == width):
        width = None
    known = ((number, _bounded(number, line, path)) for number, line in numbered_lines(text))
    lines = (_untrailed(_line(number, line, separator, full), width) for number, line in known)
    done = [f"{encoding} text, separated by {SEPARATORS[separator]}"]
    sample_rows = [_untrailed(row, width) for row in rows]
    table = table_of(lines, sample_rows, path.name, "", done, plain_reader(text, separator, width))
    if table is None:
        hint = "a log needs a header and rows of numbers"
        raise BadInput("no rows of numbers found", file=path, hint=hint)
    return table


def _with_names(rows: list[Line], sample: Sequence[tuple[int, str]]) -> list[Line]:
    """Rows that are separated by spaces, header lines among them cut into names with spaces."""
    pairs = zip(rows, sample, strict=True)
    body = [line for row, (_, line) in pairs if not row.comment and is_data(row.cells)][-SAMPLE:]
    if not body:
        return rows
    width, ends = usual_width(len(line.split()) for line in body), column_ends(body)
    out = list(rows)
    for i, (row, (_, line)) in enumerate(zip(rows, sample, strict=True)):
        if is_data(row.cells) and not row.comment and len(row.cells) == width:
            break
        mark = COMMENT.match(line)
        cells = header_cells(" " * mark.end() + line[mark.end() :] if mark else line, width, ends)
        out[i] = row if cells is None else Line(row.number, cells, row.comment)
    return out


def numbered_lines(text: str) -> Iterator[tuple[int, str]]:
    """(number, line) of the lines that are not blank, one at a time: the text is not copied.

    Cells in quotes may hold line breaks near the begin of the text, where headers are.
    """
    start, number, size = 0, 0, len(text)

    def end_from(place: int) -> int:
        found = text.find("\n", place)
        return found if found >= 0 else size

    while start < size:
        number, first = number + 1, number + 1
        stop = end_from(start)
        line = text[start:stop]
        while start < HEAD and '"' in line and line.count('"') % 2 and number - first < MOST_BREAKS and stop < size:
            number, stop = number + 1, end_from(stop + 1)
            line = text[start:stop]
        if line.count('"') % 2 and number > first:
            number, stop = first, end_from(start)
            line = text[start:stop]
        if line and not line.isspace():
            yield first, line.rstrip("\r")
        start = stop + 1


def _sample(text: str) -> list[tuple[int, str]]:
    """The first lines and some of the last ones, by which separator and layout are found."""
    first = list(itertools.islice(numbered_lines(text), FIRST_LINES + 1))
    if len(first) <= FIRST_LINES:
        return first
    tail = text[max(len(text) - HEAD, sum(len(line) + 1 for _, line in first)) :].splitlines()[1:]
    last = [line for line in tail if line.strip()][-SAMPLE:]
    return [*first[:-1], *((number, line) for number, line in enumerate(last, start=10**12))]


def _bounded(number: int, line: str, path: Path) -> str:
    """A line that can be taken apart in time: comments are cut, what is no line of a log is refused."""
    if len(line) <= LONGEST:
        return line
    if COMMENT.match(line):
        return line[:LONGEST]
    cells = max(len(line.split()) - 1, *(line.count(separator) for separator in SEPARATORS if separator != " "))
    if cells >= MOST_COLUMNS:
        hint = "export the columns that tell of the ship's motion"
        raise BadInput(f"row {number}: {cells + 1} cells; at most {MOST_COLUMNS} are read", file=path, hint=hint)
    longest = max(map(len, (*re.split(r"[;\t|,\s]", line), *re.findall(r'"[^"]*"?', line))))
    if longest > LONGEST:
        said = f"row {number}: a cell of {longest} characters; at most {LONGEST} are read"
        raise BadInput(said, file=path, hint="a log needs a header and rows of numbers")
    return line


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
    try:
        return next(csv.reader([line], delimiter=separator, skipinitialspace=True), [])
    except csv.Error:  # a cell of more than 131072 characters
        return line.split(separator)


def _line(number: int, text: str, separator: str, full: int) -> Line:
    """A line of a table with so many cells in a full row; a separator before or behind its first one is no mark of a
    comment."""
    mark = COMMENT.match(text)
    stop = mark.end() if mark else 0
    if mark and separator != " " and separator in mark[0] and text.count(separator) + 1 == full:
        stop = text.index(separator)
    return Line(number, tuple(_cells(text[stop:], separator)), bool(text[:stop].strip()))


def _untrailed(line: Line, width: int | None) -> Line:
    """A line without the empty cell at its end, where all lines of that width have one."""
    if width is None or len(line.cells) != width or line.cells[-1].strip():
        return line
    return Line(line.number, line.cells[:-1], line.comment)


# ---- Text in columns of fixed width, as Fortran writes it: exponents with D, numbers that touch, names with spaces.

EXPONENT = re.compile(r"(?<=[\d.])[dD](?=[-+]?\d{2,3}(?![\w.]))")
NUMBER = r"\d*\.\d+(?:[EeDd][-+]?\d{2,3})?"
TOUCHING = re.compile(rf"((?:(?<![\d.A-Za-z])|(?=-))[-+]?{NUMBER})(?=-{NUMBER}(?![\d.]))")
"""A number that ends where the sign of the next one stands."""
TOKEN = re.compile(r"\S+")
QUOTED = re.compile(r'"[^"]*"')
GROWN_TOGETHER = re.compile(r"(?<=[\])])(?=[A-Za-z])")
"""Between a unit in brackets and the next name of a header of fixed width, which touch: `R(DEG/S)DEL(DEG)`."""
ALIGNED = 0.4
"""Share of the lines in which a number ends where the others of its column do; those that were cut apart are longer."""


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
    apart = GROWN_TOGETHER.sub(" ", plain)
    if apart != plain and len(apart.split()) == width:
        return tuple(apart.split())
    if len(plain.split()) <= width or any(map(is_number, plain.split())):
        return None
    wide = re.split(r"\s{2,}|\t", plain)
    if len(wide) == width:
        return tuple(wide)
    if ends is None or any(re.match(r"\S\S", line[end - 1 : end + 1]) for end in ends):
        return None
    starts = [0, *ends[:-1]]
    cells = [line[a:b].strip() for a, b in zip(starts, [*ends[:-1], len(line)], strict=True)]
    return tuple(cells) if all(cells) else None


# ---- Rows of plain text at once, by Arrow where it is installed.  Plain are rows of ASCII without quotes, comments and
# repeated headers.  All others, and all rows where one looks otherwise, are left to the reader that takes line by line;
# both find the same cells, line numbers and faults.

PLAIN = bytes(sorted({*range(32, 127), *b"\t\r\n"} - {*b'"#%!*('}))
"""Characters of plain rows: none that quotes or begins a comment."""
PLAIN_SEPARATORS = ";\t|,"
MOST_FAULTS = 1000
"""Rows of another width up to which the others are plain."""


def plain_reader(text: str, separator: str, trailing: int | None) -> PlainRows | None:
    """The reader of the plain rows of a text; None where none are to be expected.

    trailing : number of cells where every line ends with a separator, as `read_text` finds it; None: none does.
    """
    if len(text) < FEWEST_BYTES or separator not in PLAIN_SEPARATORS or arrow() is None:
        return None
    return lambda layout, start: _plain_rows(text, separator, trailing, layout, start)


def _plain_rows(text: str, separator: str, trailing: int | None, layout: Layout, start: int) -> DataRows | None:
    place = 0
    for _ in range(start - 1):
        place = text.index("\n", place) + 1
    body = text[place:].encode().rstrip(b"\r\n")
    # no row may be empty, a comment, or hold a character beyond the plain ones
    plain = not (body.translate(None, PLAIN) or b"\n\n" in body or b"\n\r\n" in body or b"//" in body)
    comment = b";" in body and (re.match(rb"[ \t]*;", body) or re.search(rb"\n[ \t]*;", body))
    if trailing not in (None, layout.width + 1) or not plain or comment:
        return None
    found = _cells_of_arrow(body, separator, layout.width if trailing is None else trailing, start)
    if found is None:
        return None
    cells, odd = found
    if trailing is not None and not cells.pop().among(("",)).all():
        return None
    faults = [of_other_width(line, layout.width) for line in odd if any(cell.strip() for cell in line.cells)]
    if any(len(cell) > LONGEST for line in odd for cell in line.cells) or not _all_are_data(cells, layout):
        return None
    numbers = np.arange(start, start + len(cells[0]) + len(odd))
    return cells, np.delete(numbers, [line.number - start for line in odd]), tuple(faults), ()


def _cells_of_arrow(body: bytes, separator: str, width: int, start: int) -> tuple[list[Texts], list[Line]] | None:
    """(The texts of the columns, rows of another width); None where Arrow refuses, or there are many of these."""
    pa = arrow()
    odd: list[Line] = []

    def skip(row: Any) -> str:
        odd.append(Line(start + row.number - 1, tuple(row.text.rstrip("\r").split(separator))))
        return "skip" if len(odd) <= MOST_FAULTS else "error"

    names = [str(i) for i in range(width)]
    try:
        table = pa.csv.read_csv(
            pa.BufferReader(body),
            read_options=pa.csv.ReadOptions(column_names=names, use_threads=False),  # only then are rows numbered
            parse_options=pa.csv.ParseOptions(delimiter=separator, quote_char=False, invalid_row_handler=skip),
            convert_options=pa.csv.ConvertOptions(column_types=dict.fromkeys(names, pa.string()), check_utf8=False),
        )
    except pa.ArrowException:
        return None
    return [Texts.of_arrow(column.combine_chunks()) for column in table.columns], odd


def _all_are_data(cells: list[Texts], layout: Layout) -> bool:
    """Whether no row is a header that is repeated, empty, or has a cell that is too long."""
    if any(texts.longest > LONGEST for texts in cells):
        return False
    known = np.zeros(len(cells[0]), dtype=bool)
    for texts in cells:
        numbers = texts.floats(~texts.among(GAPS))
        known |= np.isfinite(numbers) if numbers is not None else False
        if known.all():
            return True
    rows = np.flatnonzero(~known)
    for row in zip(*(texts.take(rows) for texts in cells), strict=True):
        if not any(cell.strip() for cell in row) or is_header_again(row, layout):
            return False
    return True
