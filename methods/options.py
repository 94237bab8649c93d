"""The options of a method: names, defaults, meanings and ranges, read off its class."""

from __future__ import annotations

import inspect
import re
from dataclasses import dataclass

from ..models.argument_types import typed
from .registry import find

ENTRY = re.compile(r"^(?P<names>\w+(?:, \w+)*) : (?P<text>.*)$")


@dataclass(frozen=True)
class Option:
    """An option: its default as it is written in a method's text, what it means, and the range that tuning searches."""

    name: str
    default: str
    meaning: str
    searched: str


@typed
def method_options(text: str) -> tuple[Option, ...]:
    """Every option of the method that a text names (`ls`, `sklearn:SVR`, `my.py:Mine`), in the order of its class.

    Raises
    ------
    BadInput : there is no such method.
    """
    method = find(text.partition(",")[0].strip())
    defaults = inspect.signature(method.__init__).parameters
    meanings: dict[str, str] = {}
    for cls in reversed(method.__mro__):
        meanings |= _documented(inspect.getdoc(cls) if cls.__doc__ else None)
    values = method().get_params(deep=False)
    searched = getattr(method, "search_space", None) or {}
    return tuple(
        Option(
            name,
            _written(values[name] if name in values else defaults[name].default),
            meanings.get(name, ""),
            str(searched.get(name, "")),
        )
        for name in method.option_names()
    )


def _documented(text: str | None) -> dict[str, str]:
    """Option -> its text in the section `Parameters` of a docstring."""
    _, _, rest = (text or "").partition("Parameters\n----------\n")
    found: dict[str, str] = {}
    names: list[str] = []
    for line in rest.splitlines():
        entry = ENTRY.match(line)
        if entry:
            names = entry["names"].split(", ")
            found |= dict.fromkeys(names, entry["text"])
        elif line.startswith(" ") and names:
            found |= {name: f"{found[name]} {line.strip()}" for name in names}
        else:
            break
    return found


def _written(value: object) -> str:
    """A value as `make` reads it."""
    return str(value).lower() if isinstance(value, bool) or value is None else str(value)
