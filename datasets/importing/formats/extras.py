"""Readers that need a package of the extra `readers`."""

from __future__ import annotations

import importlib
from collections.abc import Generator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from ....models.errors import BadInput
from ....models.temporary import temporary_folder


def needed(module: str, package: str, what: str, path: Path) -> Any:
    """A module of an optional package; BadInput says what to install."""
    try:
        return importlib.import_module(module)
    except ImportError:
        hint = f"pip install 'helmbench[readers]' (or {package})"
        raise BadInput(f"{what} needs the package {package}", file=path, hint=hint) from None


@contextmanager
def as_file(data: bytes, suffix: str) -> Generator[str]:
    """The path of a copy of data, for libraries that read files only."""
    with temporary_folder() as folder:
        copy = folder / f"log{suffix}"
        copy.write_bytes(data)
        yield str(copy)
