"""Texts that are plain tables in another form: below headers of Campbell Scientific's TOA5 or of Tecplot, or on their
side, a row for every channel and a column for every time.

Each is written anew as a line of names over the data; below headers the lines keep their numbers.
"""

from __future__ import annotations

import re

import numpy as np

from ....models.number_texts import DECIMAL

TOA5 = '"TOA5"'
"""The first cell of a file of Campbell Scientific's loggers; names, units and the way of sampling stand below it."""
VARIABLES = re.compile(r"^\s*VARIABLES\s*=(?P<names>.*)$", re.IGNORECASE)
ZONE = re.compile(r"^\s*(?:ZONE\b.*|(?:SOLUTIONTIME|STRANDID|DATAPACKING|DT|I|J|K|F|T)\s*=.*)$", re.IGNORECASE)
TITLE = re.compile(r"^\s*(?:TITLE|FILETYPE)\s*=.*$", re.IGNORECASE)
QUOTED = re.compile(r'"([^"]*)"')
HEAD = 4000
"""Characters within which a header begins."""


def as_plain_table(text: str) -> tuple[str, str]:
    """(A text as a line of names over its data, what was done); the text itself and '' where it is of no such form."""
    head = text[:HEAD].lstrip("\ufeff")
    if head.startswith(TOA5):
        return _of_toa5(text), "a header of TOA5"
    if any(map(VARIABLES.match, head.splitlines())) and re.search(r"^\s*ZONE\b", head, re.IGNORECASE | re.MULTILINE):
        return _of_tecplot(text), "a header of Tecplot"
    turned = _of_side(text, max(SEPARATORS, key=head.partition("\n")[0].count))
    return turned, "a row for every channel and a column for every time: turned round" if turned is not text else ""


def _of_toa5(text: str) -> str:
    """The text without the lines of the station and of the way of sampling."""
    lines = text.split("\n", 4)
    if len(lines) < 5:
        return text
    _, names, units, _, rest = lines
    return "\n".join(["", names, units, "", rest])


def _of_tecplot(text: str) -> str:
    """The text with the names of all variables, cut by tabs, in the place of the begin of each zone."""
    lines, names = text.splitlines(), list[str]()
    for i, line in enumerate(lines):
        stated = VARIABLES.match(line)
        more = QUOTED.findall(stated["names"] if stated else line)
        if stated or (names and more and not ZONE.match(line) and not TITLE.match(line)):
            names += more or stated["names"].replace(",", " ").split() if stated else more
            lines[i] = f"# {line}"
        elif line.lstrip()[:4].upper() == "ZONE":
            lines[i] = "\t".join(names)
        elif TITLE.match(line) or ZONE.match(line):
            lines[i] = f"# {line}"
    return "\n".join(lines)


# ---- Tables on their side.

SEPARATORS = ",;\t"
NUMBER = re.compile(DECIMAL)
STAMP = re.compile(r"\d{4}-\d\d-\d\d[T ]\d\d:\d\d.*")
FEWEST_TIMES = 10


def _of_side(text: str, separator: str) -> str:
    """The text turned round, where its first line is a word and then times that rise, and the lines below it are a word
    and then numbers, those of other lengths as comments at its end."""
    stop = text.find("\n")
    head = _cells(text[:stop].lstrip("\ufeff"), separator)
    below = _cells(text[stop + 1 : stop + 1 + HEAD].partition("\n")[0], separator)[:FEWEST_TIMES]
    if len(head) <= FEWEST_TIMES or len(below) < 3 or any(map(NUMBER.fullmatch, (head[0], below[0]))):
        return text
    if not _are_times(head[1:]) or not all(not cell or NUMBER.fullmatch(cell) for cell in below[1:]):
        return text
    rows = [(line, _cells(line, separator)) for line in text[stop + 1 :].splitlines() if line.strip()]
    whole = [["time", *head[1:]], *(cells for _, cells in rows if len(cells) == len(head) and any(cells[1:]))]
    others = [f"# {line}" for line, cells in rows if len(cells) != len(head)]
    return "\n".join([*map(separator.join, zip(*whole, strict=True)), *others])


def _cells(line: str, separator: str) -> list[str]:
    return [cell.strip().strip('"') for cell in line.rstrip("\r").split(separator)]


def _are_times(cells: list[str]) -> bool:
    """Whether cells are stamps with a date, or numbers that rise and are more than counted columns."""
    if all(map(STAMP.fullmatch, cells)):
        return cells == sorted(cells)
    if not all(map(NUMBER.fullmatch, cells)):
        return False
    times = np.array(cells, dtype=float)
    return bool(np.all(np.diff(times) > 0.0)) and not np.array_equal(times - times[0], np.arange(times.size))
