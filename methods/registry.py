"""Finding methods: the files of this package, installed entry points, and the user's own files."""

from __future__ import annotations

import importlib
import importlib.util
import pkgutil
import sys
from functools import lru_cache
from importlib.metadata import entry_points
from pathlib import Path
from types import ModuleType
from typing import Any

from ..models.argument_types import typed
from ..models.errors import BadInput
from ..models.suggestions import suggestion
from .base import Method

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
    found = dict(_own())
    for point in _installed():
        cls = _plug_in(point)
        if found.setdefault(cls.name, cls) is not cls:
            raise BadInput(f"method {cls.name!r} is defined twice", file=point.value)
    return dict(sorted(found.items()))


@lru_cache(maxsize=1)
def _installed() -> tuple[Any, ...]:
    """Entry points of installed plug-ins, cached: finding them reads the metadata of every installed package."""
    return tuple(entry_points(group=GROUP))


@lru_cache(maxsize=1)
def _own() -> dict[str, type[Method]]:
    package = importlib.import_module(__name__.rpartition(".")[0])
    found: dict[str, type[Method]] = {}
    for entry in pkgutil.iter_modules(package.__path__):
        for cls in methods_in(importlib.import_module(f"{package.__name__}.{entry.name}")):
            if found.setdefault(cls.name, cls) is not cls:
                raise BadInput(f"method {cls.name!r} is defined twice", file=entry.name)
    return found


def methods_in(module: ModuleType) -> list[type[Method]]:
    """The named methods that a module defines itself (not those it imports)."""
    return [
        value
        for value in vars(module).values()
        if isinstance(value, type) and issubclass(value, Method) and value.name and value.__module__ == module.__name__
    ]


def _plug_in(point: Any) -> type[Method]:
    try:
        cls = point.load()
    except Exception as error:  # whatever a foreign package raises while it is imported
        raise BadInput(f"method plug-in cannot be loaded: {error}", file=point.value) from error
    return _checked(cls, point.value)


def _checked(cls: Any, where: str) -> type[Method]:
    if not (isinstance(cls, type) and issubclass(cls, Method) and cls.name):
        raise BadInput("not a subclass of helmbench.methods.base.Method with a name", file=where)
    return cls


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
        path, _, name = text.rpartition(":")
        return _checked(getattr(load_file(path), name, None), text)
    known = methods()
    if text not in known:
        others = ", ".join(f"{prefix}:NAME" for prefix in FAMILIES)
        hint = suggestion(text, known, f"known: {', '.join(known)}; or {others}, path.py:Class")
        raise BadInput(f"unknown method {text!r}", hint=hint)
    return known[text]


def load_file(path: str) -> ModuleType:
    """The user's own Python file as a module.

    Raises
    ------
    BadInput : the file does not exist or cannot be loaded.
    """
    file = Path(path).resolve()
    if not file.is_file():
        raise BadInput("no such file", file=path)
    name = f"helmbench_user_{file.stem}"
    spec = importlib.util.spec_from_file_location(name, file)
    if spec is None or spec.loader is None:
        raise BadInput("not a Python file", file=path)
    module = importlib.util.module_from_spec(spec)
    sys.modules[name] = module
    try:
        spec.loader.exec_module(module)
    except Exception as error:  # whatever the user's file raises
        raise BadInput(f"{type(error).__name__}: {error}", file=path) from error
    return module


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


def _value(text: str) -> Any:
    words = {"true": True, "false": False, "none": None}
    if text.lower() in words:
        return words[text.lower()]
    for kind in (int, float):
        try:
            return kind(text)
        except ValueError:
            continue
    return text
