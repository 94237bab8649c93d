"""Results as JSON text, and written as files of a folder."""

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


def write_together(folder: Path, writers: Mapping[str, Callable[[Path], object]]) -> tuple[Path, ...]:
    """Write files of a folder, which is made if need be: all of them or none.

    writers : name of the file -> function that writes it to a path.

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
    try:
        replace_together({folder / name: write for name, write in writers.items()})
    except BaseException:
        if created:
            folder.rmdir()
        raise
    return tuple(folder / name for name in writers)
