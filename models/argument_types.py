"""Arguments of a wrong type are told by their names, as bad input."""

from __future__ import annotations

import ast
import inspect
import os
from collections.abc import Callable, Iterable, Iterator, Mapping
from functools import lru_cache, wraps
from numbers import Integral, Real
from typing import Any, ParamSpec, TypeVar

from .errors import BadInput
from .extras import extras_told

P = ParamSpec("P")
R = TypeVar("R")
Fits = Callable[[object], bool]
PATHS = ("Path", "FilePath", "PathLike")
SIMPLE: dict[str, tuple[str, Fits]] = {
    "None": ("None", lambda value: value is None),
    "str": ("a text", lambda value: isinstance(value, str)),
    "bool": ("True or False", lambda value: isinstance(value, bool) or type(value).__name__ in ("bool", "bool_")),
    "int": ("a whole number", lambda value: isinstance(value, Integral) and not isinstance(value, bool)),
    "float": ("a number", lambda value: _is_number(value)),
    "Mapping": ("a mapping", lambda value: isinstance(value, Mapping)),
    **{name: ("a path", lambda value: isinstance(value, str | os.PathLike)) for name in PATHS},
}
CLASSES = {name: name for name in ("Record", "Model", "Method", "Case", "SuiteResults")} | {"ColumnMapping": "Mapping"}
"""Name in annotations -> class of the package; known by their names, so that none is imported for it."""


def typed(function: Callable[P, R]) -> Callable[P, R]:
    """The function, which raises BadInput with the name of the argument for one that its annotation does not allow, and
    where it needs a package of an extra that is not installed.

    Annotations with types that are not known here allow everything.
    """
    parameters = inspect.signature(function).parameters

    @wraps(function)
    def checked(*args: P.args, **kwargs: P.kwargs) -> R:
        for name, value in _given(parameters, args, kwargs):
            annotation = parameters[name].annotation
            if isinstance(annotation, str) and not _allows(annotation, value):
                raise BadInput(f"{name} is {shown(value)}", hint=f"give {' or '.join(_words(annotation))}")
        with extras_told():
            return function(*args, **kwargs)

    return checked


def _is_number(value: object) -> bool:
    """Whether a value is a number that fits into a float."""
    if not isinstance(value, Real) or isinstance(value, bool):
        return False
    try:
        float(value)
    except OverflowError:  # a whole number of hundreds of digits
        return False
    return True


def shown(value: object) -> str:
    """A value in short; of a long whole number its type."""
    long = isinstance(value, int) and value.bit_length() > 64
    return f"a {type(value).__name__}" if long else f"{value!r}"[:80]


def _given(parameters: Mapping[str, inspect.Parameter], args: tuple, kwargs: Mapping[str, Any]) -> Iterator:
    """Names and values of the arguments that were given, those of *args and **kwargs left aside."""
    positional = [n for n, p in parameters.items() if p.kind in (p.POSITIONAL_ONLY, p.POSITIONAL_OR_KEYWORD)]
    yield from zip(positional, args, strict=False)
    yield from ((n, v) for n, v in kwargs.items() if n in parameters and parameters[n].kind is not _REST)


_REST = inspect.Parameter.VAR_KEYWORD


@lru_cache(maxsize=256)
def _parts(annotation: str) -> tuple[tuple[str, str], ...]:
    """Alternatives of an annotation: the name of each, and the annotation of its items where it is a sequence."""
    found: list[tuple[str, str]] = []
    left = [ast.parse(annotation, mode="eval").body]
    while left:
        node = left.pop(0)
        if isinstance(node, ast.BinOp):
            left = [node.left, node.right, *left]
        elif isinstance(node, ast.Subscript):
            own = _name(node.value)
            found.append((own, ast.unparse(node.slice) if own in ("Sequence", "Iterable") else ""))
        else:
            found.append((_name(node), ""))
    return tuple(found)


def _name(node: ast.expr) -> str:
    return ast.unparse(node).rpartition(".")[2]


def _allows(annotation: str, value: object) -> bool:
    return any(_fits(name, items, value) for name, items in _parts(annotation))


def _fits(name: str, items: str, value: object) -> bool:
    if name in SIMPLE:
        return SIMPLE[name][1](value)
    if name in ("Sequence", "Iterable"):
        if not isinstance(value, Iterable) or isinstance(value, bytes | Mapping):
            return False
        return not isinstance(value, list | tuple) or all(_allows(items, one) for one in value)
    return name not in CLASSES or any(cls.__name__ == CLASSES[name] for cls in type(value).__mro__)


def _words(annotation: str) -> list[str]:
    """What an annotation allows, in words."""
    words = []
    for name, items in _parts(annotation):
        if name in ("Sequence", "Iterable"):
            words.append(f"several of these ({' or '.join(_words(items))})")
        elif name != "None":
            words.append(SIMPLE[name][0] if name in SIMPLE else f"a {name}")
    return list(dict.fromkeys(words))
