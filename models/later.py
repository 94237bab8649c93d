"""Modules that are imported where they are first used: SymPy takes a second, and a warm start does without it."""

from __future__ import annotations

from importlib import import_module
from typing import Any


class Later:
    """A module by its name, imported as soon as an attribute of it is asked for.

    package : where a relative name starts from.
    """

    def __init__(self, name: str, package: str | None = None) -> None:
        self._name, self._package = name, package

    def __getattr__(self, attribute: str) -> Any:
        return getattr(import_module(self._name, self._package), attribute)
