"""Finding what the files of a folder, installed plug-ins and the user's own files define."""

from __future__ import annotations

import importlib
import importlib.util
import inspect
import pkgutil
import sys
from collections.abc import Iterable, Iterator, Mapping
from functools import lru_cache
from importlib.metadata import entry_points
from pathlib import Path
from types import ModuleType
from typing import Any, TypeVar

from .errors import BadInput
from .suggestions import suggestion

T = TypeVar("T")
V = TypeVar("V")


def modules_in(package: str | None) -> Iterator[ModuleType]:
    """The modules of a package (a file's `__package__`) in the order of their names, without those that begin with
    `_`."""
    for entry in pkgutil.iter_modules(importlib.import_module(f"{package}").__path__):
        if not entry.name.startswith("_"):
            yield importlib.import_module(f"{package}.{entry.name}")


def classes_in(module: ModuleType, base: type[T], name: str = "id") -> list[type[T]]:
    """The concrete subclasses of `base` with a name (attribute `name`) that a module defines itself."""
    own = (value for value in vars(module).values() if getattr(value, "__module__", "") == module.__name__)
    return [value for value in own if _is_named(value, base, name) and not inspect.isabstract(value)]


def classes_of(package: str | None, base: type[T], name: str = "id") -> list[type[T]]:
    """The same of all modules of a package."""
    return [cls for module in modules_in(package) for cls in classes_in(module, base, name)]


def plug_ins(group: str, what: str, base: type[T], name: str = "id") -> list[type[T]]:
    """Classes that other packages add under a group of entry points.

    Raises
    ------
    BadInput : one cannot be loaded, or is no subclass of `base` with a name.
    """
    found = []
    for point in _points(group):
        try:
            value = point.load()
        except Exception as error:  # whatever a foreign package raises while it is imported
            raise BadInput(f"{what} plug-in cannot be loaded: {error}", file=point.value) from error
        found.append(_checked(value, point.value, base, name))
    return found


@lru_cache(maxsize=8)
def _points(group: str) -> tuple[Any, ...]:
    """Entry points of installed packages, cached: finding them reads the metadata of every one."""
    return tuple(entry_points(group=group))


def class_in_file(text: str, base: type[T], name: str = "id") -> type[T]:
    """The class that `path.py:Class` names.

    Raises
    ------
    BadInput : the file does not exist or cannot be loaded, or it is no subclass of `base` with a name.
    """
    path, _, wanted = text.rpartition(":")
    return _checked(getattr(_loaded(path), wanted, None), text, base, name)


def _is_named(value: Any, base: type, name: str) -> bool:
    """Whether a value is a subclass of `base` with a name."""
    return isinstance(value, type) and issubclass(value, base) and bool(getattr(value, name, ""))


def _checked(value: Any, where: str, base: type[T], name: str) -> type[T]:
    """A value that is a subclass of `base` with a name; else BadInput."""
    if not _is_named(value, base, name):
        raise BadInput(f"not a subclass of {base.__module__}.{base.__qualname__} that sets {name!r}", file=where)
    return value


def by_name(what: str, things: Iterable[V], name: str = "id") -> dict[str, V]:
    """Name -> class or object, sorted; BadInput if two have the same name."""
    found: dict[str, V] = {}
    for thing in things:
        own = getattr(thing, name)
        if found.setdefault(own, thing) is not thing:
            raise BadInput(f"{what} {own!r} is defined twice", file=thing.__module__)
    return dict(sorted(found.items()))


def known(what: str, name: str, all_known: Mapping[str, V], otherwise: str = "") -> V:
    """What has a name; BadInput with a near name, or else with `otherwise`, if nothing has."""
    if name not in all_known:
        raise BadInput(f"unknown {what} {name!r}", hint=suggestion(name, all_known, otherwise))
    return all_known[name]


def _loaded(path: str) -> ModuleType:
    """The user's own Python file as a module; BadInput if it does not exist or cannot be loaded."""
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
