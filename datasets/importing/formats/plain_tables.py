"""Texts that are plain tables in another form.

Below headers of Campbell Scientific's TOA5, of Tecplot or of LabVIEW's measurement files, in pairs of channel and
value as Expedition writes them, or on their side, a row for every channel and a column for every time.

Each is written anew as a line of names over the data; below headers the lines keep their numbers.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping, Sequence

import numpy as np

from ....models.errors import BadInput
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
    """(A text as a line of names over its data, what was done); the text itself and '' where it is of no such form.

    Raises
    ------
    BadInput : no row of a table on its side is whole.
    """
    head = text[:HEAD].lstrip("\ufeff")
    if head.startswith(TOA5):
        return _of_toa5(text), "a header of TOA5"
    if head.lstrip().startswith("LabVIEW Measurement"):
        return _of_labview(text), "a LabVIEW measurement file"
    if re.match(r"!?\s*boat\s*,\s*utc\s*,", head, re.IGNORECASE):
        return _of_expedition(text), "a log of Expedition"
    if any(map(VARIABLES.match, head.splitlines())) and re.search(r"^\s*ZONE\b", head, re.IGNORECASE | re.MULTILINE):
        # the text with the names of all variables, cut by tabs, in the place of the begin of each zone
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
        return "\n".join(lines), "a header of Tecplot"
    turned = _of_side(text, max(SEPARATORS, key=head.partition("\n")[0].count))
    return turned, "a row for every channel and a column for every time: turned round" if turned is not text else ""


def _of_toa5(text: str) -> str:
    """The text without the lines of the station and of the way of sampling."""
    lines = text.split("\n", 4)
    if len(lines) < 5:
        return text
    _, names, units, _, rest = lines
    return "\n".join(["", names, units, "", rest])


# ---- LabVIEW measurement files (.lvm): a header of names and values, one or more segments of rows below such headers.

END = "***End_of_Header***"
SINCE_1904 = -2082844800.0
"""Seconds since 1970 of LabVIEW's begin of time."""


def _of_labview(text: str) -> str:
    """The text without the headers, names with their units, times since 1970 where they are absolute, and the time step
    where rows have no time."""
    lines = text.lstrip("\ufeff").splitlines()
    separator = "," if any(line.lower().startswith("separator,") for line in lines[:40]) else "\t"
    rows = [[cell.strip() for cell in line.split(separator)] for line in lines]
    file, place, out, kept = dict[str, list[str]](), "file", [""] * len(lines), list[int]()
    head, timed = file, list[int]()
    for i, cells in enumerate(rows):
        if place in ("between", "rows") and cells[0] == "Channels":
            head, place = dict(file), "head"
        if cells[0] == END:
            place = "between" if place == "file" else "names"
        elif place in ("file", "head"):
            head[cells[0]] = cells[1:]
        elif place == "rows":
            own = [cells[k] if k < len(cells) else "" for k in kept]
            absolute = head.get("Time_Pref", [""])[:1] == ["Absolute"]
            out[i] = separator.join(
                (f"{_decimal(c) + SINCE_1904:.9f}" if c else "") if absolute and k in timed else c
                for k, c in zip(kept, own, strict=True)
            )
        elif any(cells):
            place, kept = "rows", [k for k, name in enumerate(cells) if name and name.lower() != "comment"]
            timed = [k for k in kept if cells[k].lower().startswith("x_value")]
            out[i] = separator.join(_names([cells[k] for k in kept], [k in timed for k in kept], head))
            below = next((row for row in rows[i + 1 :] if any(row)), [])
            if not any(below[k] for k in timed if k < len(below)):
                out[i - 1] = f"# dt = {_decimal(head.get('Delta_X', ['nan'])[0])} s"
    return "\n".join(out) if kept else text


def _names(names: Sequence[str], timed: Sequence[bool], head: Mapping[str, Sequence[str]]) -> Iterator[str]:
    """The names of a segment with the units of its channels; several times, and absolute ones, are called so."""
    units = iter(head.get("Y_Unit_Label", ()))
    called = sum(timed) > 1 or head.get("Time_Pref", [""])[:1] == ["Absolute"]
    for name, is_time in zip(names, timed, strict=True):
        unit = "s" if is_time else next(units, "")
        yield f"{'time' if is_time and called else name}{f' [{unit}]' if unit and '[' not in name else ''}"


def _decimal(text: str) -> float:
    try:
        return float(text.replace(",", "."))
    except ValueError:
        return float("nan")


# ---- Expedition, a racing program: names and numbers of channels, then pairs of number and value, of several boats.

UNITS_OF_EXPEDITION = {
    **dict.fromkeys(("bsp", "aws", "tws", "sog"), " [kn]"),
    **dict.fromkeys(("awa", "twa", "twd", "cog", "hdg", "heel", "trim", "rudder", "lat", "lon", "leeway"), " [deg]"),
}


def _of_expedition(text: str) -> str:
    """The channels of the own boat (0), with the units that the program states."""
    names, places, *rows = ([cell.strip() for cell in line.split(",")] for line in [*text.splitlines(), ""])
    of_own = [dict(zip(cells[1::2], cells[2::2], strict=False)) if cells[0] == "0" else {} for cells in rows]
    channels = dict(zip(places[1:], names[1:], strict=False))
    used = {k: name for k, name in channels.items() if any(k in row for row in of_own)} or channels
    header = [name + UNITS_OF_EXPEDITION.get(name.lower(), "") for name in used.values()]
    return "\n".join(["", ",".join(header), *(",".join(row.get(k, "") for k in used) if row else "" for row in of_own)])


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
    if len(whole) < 2:
        raise BadInput("no row has a number for every time", hint="is the file whole? export it again")
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
