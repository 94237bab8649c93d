"""Results as JSON text, and as files that are written all or not at all."""

from __future__ import annotations

import json
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

from ..models.errors import BadInput


def json_text(value: Any) -> str:
    """A value as indented JSON; what is not a finite number is null."""
    from ..bench.store import plain

    return json.dumps(plain(value), indent=1, allow_nan=False)


def write_folder(folder: Path, writers: Mapping[str, Callable[[Path], object]]) -> tuple[Path, ...]:
    """Write files into a folder, which is made where it is missing: all of them or none.

    Parameters
    ----------
    writers : name of a file -> function that writes it to a given place.

    Raises
    ------
    BadInput : the folder cannot be made or written to.
    """
    from ..datasets.files import replace_together

    created = not folder.exists()
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise BadInput(f"cannot be made ({error.strerror or error})", file=folder) from None
    paths = tuple(folder / name for name in writers)
    try:
        replace_together(dict(zip(paths, writers.values(), strict=True)))
    except BaseException:
        if created:
            folder.rmdir()
        raise
    return paths
