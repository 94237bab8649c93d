"""Texts from files in generated sources, where they must be neither code nor markup."""

from __future__ import annotations

import builtins
import keyword
import re
import string
import sys
from collections.abc import Iterable
from functools import lru_cache
from pathlib import Path
from typing import TYPE_CHECKING
from unicodedata import bidirectional, normalize
from unicodedata import name as name_of_letter

if TYPE_CHECKING:
    from jinja2 import Template

APOSTROPHE = "\u2019"
PUNCTUATION = frozenset(f" .,:;()[]+-=_/&{APOSTROPHE}")
"""Characters beside letters and digits that stay: none ends a comment or a literal of C, Python, MATLAB or XML."""
MOST_LETTERS, MOST_OF_NAME = 500, 50
"""Letters that stay of a text, and of a name: MATLAB reads 63 of a file's name, with an ending such as `_idnlgrey`."""
_C = (
    "auto break case char const continue default do double else enum extern float for goto if inline int long register "
    "restrict return short signed sizeof static struct switch typedef union unsigned void volatile while"
)
_MATLAB = (
    "case catch classdef elseif end function global otherwise parfor persistent spmd switch sys data dx ts "
    "state input coefficients varargin sign atan2 double sin cos exp sqrt eye zeros pi inf nan idgrey idnlgrey"
)
_FILES = "con prn aux nul com1 com2 com3 com4 com5 com6 com7 com8 com9 lpt1 lpt2 lpt3 lpt4 lpt5 lpt6 lpt7 lpt8 lpt9"
RESERVED = frozenset(word.lower() for word in (*keyword.kwlist, *sys.stdlib_module_names, *dir(builtins)))
RESERVED |= {*_C.split(), *_MATLAB.split(), *_FILES.split(), "np", "numpy", "derivative", "rudder"}
"""Names, in small letters, that mean something else in C, Python, MATLAB or to a file system."""


def inert(text: str) -> str:
    """One line that is neither code nor markup in a comment or literal of C, Python, MATLAB or XML.

    Letters that are written from left to right, ASCII digits and `PUNCTUATION` stay, apostrophes become
    typographic ones, a run of hyphens becomes one, and every other character becomes `_`.
    """
    line = " ".join(normalize("NFC", text).replace("'", APOSTROPHE).split())
    return re.sub("-{2,}", "-", "".join(letter if _stays(letter) else "_" for letter in line[:MOST_LETTERS]))


def _stays(letter: str) -> bool:
    if letter.isascii():
        return letter.isalnum() or letter in PUNCTUATION
    visible = letter.isalpha() and bidirectional(letter) == "L" and "FILLER" not in name_of_letter(letter, "FILLER")
    return visible or letter in PUNCTUATION


def name_of(text: str, taken: Iterable[str] = ()) -> str:
    """A text as a name of C, Python and MATLAB and of a file: two or more ASCII letters, digits and `_`, none of
    `RESERVED` and of the names that are taken."""
    found = re.sub(r"\W+", "_", text, flags=re.ASCII).strip("_")[:MOST_OF_NAME] or "model"
    taken = RESERVED.union(map(str.lower, taken))
    return f"model_{found}" if found[0] in string.digits or len(found) == 1 or found.lower() in taken else found


@lru_cache
def template(name: str) -> Template:
    """A Jinja template of this folder, whose filters are `inert` and `repr` too."""
    from jinja2 import Environment, FileSystemLoader, StrictUndefined

    made = Environment(
        loader=FileSystemLoader(Path(__file__).parent),
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
        keep_trailing_newline=True,
    )
    made.filters |= {"inert": inert, "repr": repr}
    return made.get_template(f"{name}.j2")
