"""Kinds of suites: one folder each, found by its name.

A folder holds `kind.py` with a `base.Kind` named `KIND`, and `suite.py` with the models of its suite files.
"""

from __future__ import annotations

from functools import cache
from importlib import import_module
from pathlib import Path

from ...models.errors import BadInput
from .base import Kind

IDENTIFICATION, DIAGNOSIS = "identification", "diagnosis"


def kind_names() -> list[str]:
    """Names of the kinds."""
    return sorted(path.parent.name for path in Path(__file__).parent.glob("*/kind.py"))


def kind_of(name: object, file: object = None) -> Kind:
    """The kind of that name; `BadInput`, which names the file, if there is none."""
    if name not in kind_names():
        raise BadInput(f"unknown kind {name!r}", file=file, hint=f"known: {', '.join(kind_names())}")
    return _load(str(name))


@cache
def _load(name: str) -> Kind:
    return import_module(f".{name}.kind", __package__).KIND
