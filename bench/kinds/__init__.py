"""Kinds of suites: one folder each, found by its name.

A folder holds `kind.py` with a `base.Kind` named `KIND`, and `suite.py` with the `MODELS` of its suite files.
"""

from __future__ import annotations

from importlib import import_module
from pathlib import Path
from typing import Any

from ...models.errors import BadInput
from ...models.yaml_file import FileContent
from .base import Kind

IDENTIFICATION, DIAGNOSIS = "identification", "diagnosis"


def kind_names() -> list[str]:
    """Names of the kinds."""
    return sorted(path.parent.name for path in Path(__file__).parent.glob("*/kind.py"))


def kind_of(name: object, file: object = None) -> Kind:
    """The kind of that name; `BadInput`, which names the file, if there is none."""
    return _module(name, "kind", file).KIND


def suite_models(name: object, file: object = None) -> tuple[type[FileContent], type[FileContent]]:
    """What a suite file of that kind holds beside its entries, and an entry, as pydantic models; as `kind_of`."""
    return _module(name, "suite", file).MODELS


def _module(name: object, part: str, file: object) -> Any:
    if name not in kind_names():
        raise BadInput(f"unknown kind {name!r}", file=file, hint=f"known: {', '.join(kind_names())}")
    return import_module(f".{name}.{part}", __package__)
