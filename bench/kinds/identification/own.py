"""Ships and records of the user's own: files that a suite or the command line names."""

from __future__ import annotations

import hashlib
from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path

from ....datasets.measured import data_dir
from ....models.errors import BadInput
from ....models.files import read_bytes
from ....models.model import list_vessels, resolve

SUFFIXES = (".yaml", ".yml", ".json")


@dataclass(frozen=True)
class OwnVessel:
    """A vessel by its id, or one of the user's own by its id and its file."""

    id: str
    file: str | None = None

    @property
    def text(self) -> str:
        """What `resolve` takes."""
        return self.file or self.id


def is_file_name(text: str) -> bool:
    """Whether a text names a file of a vessel or model, not an id."""
    return text.endswith(SUFFIXES)


def ship_of(text: str, folder: Path) -> OwnVessel:
    """The ship of an id or a file.

    Raises
    ------
    BadInput : the file cannot be used, or its ship has the id of a shipped vessel.
    """
    if not is_file_name(text):
        return OwnVessel(text)
    file = located(text, folder)
    model = resolve(file)
    if model.id in list_vessels():
        raise BadInput(f"{model.id!r} is a vessel that ships with helmbench", file=file, hint="give yours another id")
    return OwnVessel(model.id, file)


def located(text: str, folder: Path) -> str:
    """Path of a file: beside the suite file, else in the folder of measured data, else from the working directory."""
    places = (folder / text, data_dir() / text)
    return next((str(place) for place in places if place.is_file()), text)


def digest(files: Sequence[str]) -> str | None:
    """Digest of the content of files; None of no file: it enters what a result depends on."""
    return hashlib.sha256("".join(map(_digest, files)).encode()).hexdigest()[:16] if files else None


@lru_cache(maxsize=256)
def _digest(file: str) -> str:
    side = Path(file).with_suffix(".yaml")
    parts = [read_bytes(Path(file))] + ([read_bytes(side)] if side.is_file() and str(side) != file else [])
    return hashlib.sha256(b"\0".join(parts)).hexdigest()
