"""What an identifier of a family of equations may look like: nothing else is looked up, least of all on the disk."""

from __future__ import annotations

import re

from .errors import BadInput

MOST_LETTERS = 200
_WORD = "[A-Za-z0-9_]+"
_NAME = re.compile(rf"[a-z0-9]+(-[a-z0-9]+)*(\+{_WORD})*(~{_WORD})*")


def is_family_name(name: object) -> bool:
    """Whether a text has the form of an identifier: `nomoto-1`, `abkowitz+rudder_offset`."""
    return isinstance(name, str) and len(name) <= MOST_LETTERS and _NAME.fullmatch(name) is not None


def check_family_name(name: object, file: object = None) -> None:
    """Refuse what cannot be the identifier of a family, such as a path; BadInput names the file that it stands in."""
    if not is_family_name(name):
        shown = repr(name)
        shown = shown if len(shown) <= 60 else f"{shown[:57]}..."
        raise BadInput(f"unknown model family {shown}", file=file, hint="'helmbench list models' shows the families")
