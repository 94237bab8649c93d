"""Finding methods: the files of this package, installed entry points, and the user's own files."""

from __future__ import annotations

import importlib
from functools import lru_cache
from typing import Any

from ..models.argument_types import typed
from ..models.discovery import by_name, class_in_file, classes_of, known, plug_ins
from ..models.errors import BadInput
from ..models.number_texts import number_of, whole_of
from .base import Method
from .options import Option

GROUP = "helmbench.methods"
"""Entry-point group by which other packages add methods."""
FAMILIES = {
    "sklearn": ("black_box", "regressor", "any scikit-learn regressor as a black box: sklearn:SVR,C=100"),
    "tuned": ("tuned", "tuned", "a method with its options tuned: tuned:METHOD,tuner=abc,trials=40"),
}
"""Prefix -> module and function that make a method class from the text after the colon, and a title."""


def methods() -> dict[str, type[Method]]:
    """Identifier -> class of every method, sorted: those of this package and those of installed plug-ins.

    Raises
    ------
    BadInput : if two methods have the same identifier, or a plug-in cannot be loaded.
    """
    return by_name("method", [*_own(), *plug_ins(GROUP, "method", Method, "name")], "name")


@lru_cache(maxsize=1)
def _own() -> list[type[Method]]:
    return classes_of(__package__, Method, "name")


def find(text: str) -> type[Method]:
    """The method class that `text` names: an identifier, `path.py:Class`, or one of a family (`sklearn:SVR`).

    Raises
    ------
    BadInput : if there is none.
    """
    prefix, colon, rest = text.partition(":")
    if colon and prefix in FAMILIES:
        module, maker, _ = FAMILIES[prefix]
        return getattr(importlib.import_module(f"{__package__}.{module}"), maker)(rest)
    if ".py:" in text:
        return class_in_file(text, Method, "name")
    every, others = methods(), ", ".join(f"{prefix}:NAME" for prefix in FAMILIES)
    return known("method", text, every, f"known: {', '.join(every)}; or {others}, path.py:Class")


@typed
def make(text: str, **options: Any) -> Method:
    """A method from text: `ls`, `ls,scheme=midpoint`, `fw-rls,mu=0.99,variant=as_printed`, `my.py:Mine,gain=2`.

    Options after commas are numbers, true, false, none or words; keyword arguments are further options.

    Raises
    ------
    BadInput : for an unknown method or option.
    """
    head, *rest = (part.strip() for part in text.split(","))
    method = find(head)()
    given: dict[str, Any] = {}
    for part in rest:
        key, equals, value = part.partition("=")
        if not equals:
            raise BadInput(f"method option {part!r} is not of the form name=value")
        given[key.strip()] = _value(value.strip())
    method.set_params(**given, **options)
    method.check_options()
    return method


@typed
def method_options(text: str) -> tuple[Option, ...]:
    """Every option of the method that a text names (`ls`, `sklearn:SVR`, `my.py:Mine`), in the order of its class.

    Raises
    ------
    BadInput : there is no such method.
    """
    return tuple(find(text.partition(",")[0].strip()).options.values())


def _value(text: str) -> Any:
    words = {"true": True, "false": False, "none": None}
    if text.lower() in words:
        return words[text.lower()]
    for read in (whole_of, number_of):
        try:
            return read(text)
        except ValueError:
            continue
    return text
