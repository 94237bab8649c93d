"""What the result of an identification run depends on: its task, its method's sources and those that score it."""

from __future__ import annotations

import hashlib
from functools import lru_cache
from pathlib import Path

from ...content import PACKAGE, ROOT, sources_digest
from .plan import RunSpec

RUN = (Path(__file__).parent, ROOT / "bench" / "scores")
"""Folders all of whose files make the row of a run."""


def content(spec: RunSpec) -> str | None:
    """Digest of a run's task, options, sources and versions; None where its method's sources are not all known."""
    sources = _sources(spec.maker.partition(",")[0])
    if sources is None:
        return None
    return hashlib.sha256(f"{spec.text(suite='')}{sources}".encode()).hexdigest()[:20]


@lru_cache(maxsize=256)
def _sources(method: str) -> str | None:
    """Digest of the sources of a method, named as in `methods.registry.find`."""
    own = [_module(path) for folder in RUN for path in folder.glob("*.py")]
    return sources_digest(*sorted({*own, *_modules(method)}))


def _modules(method: str) -> list[str]:
    """Modules and files that define a method's class, its base classes, and the method or package that it wraps."""
    from ....methods.registry import FAMILIES, find

    prefix, colon, rest = method.partition(":")
    if colon and prefix in FAMILIES:
        wrapped = _modules(rest) if prefix == "tuned" else [rest.partition(".")[0] if "." in rest else prefix]
        return [f"{PACKAGE}.methods.{FAMILIES[prefix][0]}", *wrapped]
    if ".py:" in method:
        return [method.rpartition(":")[0]]
    return [cls.__module__ for cls in find(method).__mro__ if cls.__module__ not in ("builtins", "abc")]


def _module(path: Path) -> str:
    return ".".join([PACKAGE, *path.relative_to(ROOT).with_suffix("").parts])
