"""Vessels as data: one YAML file each, with unit and source per coefficient."""

from __future__ import annotations

from functools import lru_cache
from pathlib import Path
from typing import Any

from .errors import BadInput

FOLDER = Path(__file__).parent / "vessels"


@lru_cache
def vessel_files() -> dict[str, Path]:
    """Vessel id -> its data file."""
    return {path.stem: path for path in sorted(FOLDER.glob("*.yaml"))}


@lru_cache
def read_vessel(path: Path) -> dict[str, Any]:
    """The checked content of a vessel file.

    Raises
    ------
    BadInput : if a key is missing or unknown, or a number lacks its unit or source.
    """
    from .model_file import VesselFile
    from .yaml_file import checked, read_yaml

    facts = read_yaml(path, "a vessel file")
    if checked(VesselFile, facts, path).id != path.stem:
        raise BadInput(f"id {facts['id']!r} differs from the file's name", file=path)
    return facts
