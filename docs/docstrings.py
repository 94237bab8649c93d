"""Sphinx extension: docstrings of this package as field lists.

Sections `Parameters`, `Returns` and `Raises` are underlined; an entry is "name : text", goes on in indented lines, and
ends with the next entry or with text that is no entry.
"""

import re

FIELDS = {"Parameters": "param {}", "Attributes": "param {}", "Raises": "raises {}", "Returns": "returns"}
ENTRY = re.compile(r"^([\w*., ]+?) : (.*)$")
TOLD = re.compile(r"(?<=[.;]) {2,}(?=[\w, ]+ : )")
"""Between entries that share a line."""


def field_lists(lines: list[str]) -> list[str]:
    """The lines of a docstring with its sections as fields."""
    out: list[str] = []
    section = None
    for number, line in enumerate(lines):
        follows = lines[number + 1] if number + 1 < len(lines) else ""
        if line in FIELDS and re.fullmatch(r"-{3,}", follows):
            section = line
            out.append("")
        elif re.fullmatch(r"-{3,}", line) and section is not None and lines[number - 1] == section:
            continue
        elif section is None:
            out.append(line)
        elif line.strip():
            section = _entry(section, line, out)
        elif follows and not follows.startswith(" ") and not ENTRY.match(follows) and follows not in FIELDS:
            section = None
            out.append("")
    return out


def _entry(section: str, line: str, out: list[str]) -> str | None:
    """Add a line of a section; None where the section has ended with it."""
    if line.startswith(" "):
        out.append("    " + line.strip())
        return section
    if section == "Returns":
        out.append(f":returns: {line}" if not out or not out[-1].startswith(":returns") else f"    {line}")
        return section
    for piece in TOLD.split(line):
        entry = ENTRY.match(piece)
        if entry is None:
            out.extend(["", piece])
            return None
        out.append(f":{FIELDS[section].format(entry[1].strip())}: {entry[2]}")
    return section


def _process(app, what: str, name: str, thing: object, options: object, lines: list[str]) -> None:
    lines[:] = field_lists(lines)


def setup(app) -> dict[str, bool]:
    app.connect("autodoc-process-docstring", _process)
    return {"parallel_read_safe": True, "parallel_write_safe": True}
