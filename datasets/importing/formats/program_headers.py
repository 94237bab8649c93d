"""Headers that programs write above a plain table: Campbell Scientific's TOA5, ASCII files of Tecplot.

Each is written anew as a line of names over the data; the lines keep their numbers.
"""

from __future__ import annotations

import re

TOA5 = '"TOA5"'
"""The first cell of a file of Campbell Scientific's loggers; names, units and the way of sampling stand below it."""
VARIABLES = re.compile(r"^\s*VARIABLES\s*=(?P<names>.*)$", re.IGNORECASE)
ZONE = re.compile(r"^\s*(?:ZONE\b.*|(?:SOLUTIONTIME|STRANDID|DATAPACKING|DT|I|J|K|F|T)\s*=.*)$", re.IGNORECASE)
TITLE = re.compile(r"^\s*(?:TITLE|FILETYPE)\s*=.*$", re.IGNORECASE)
QUOTED = re.compile(r'"([^"]*)"')
HEAD = 4000
"""Characters within which a header begins."""


def with_plain_header(text: str) -> str:
    """A text whose header is a line of names over its data; the text itself where its header is of no such program."""
    head = text[:HEAD].lstrip("\ufeff")
    if head.startswith(TOA5):
        return _of_toa5(text)
    if any(map(VARIABLES.match, head.splitlines())) and re.search(r"^\s*ZONE\b", head, re.IGNORECASE | re.MULTILINE):
        return _of_tecplot(text)
    return text


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
