"""Files of exams and submissions, which may come from elsewhere."""

from __future__ import annotations

from pathlib import Path

from ...models.errors import BadInput
from ...models.folders import check_regular, read_regular


def read_file(path: Path, most: int) -> bytes:
    """A regular file of at most `most` bytes; BadInput where it is missing, a link or larger."""
    if not check_regular(path):
        raise BadInput("no such file", file=path)
    return read_regular(path, most=most)
