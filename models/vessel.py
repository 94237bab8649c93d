"""Vessels as data: one YAML file each, with unit and source per coefficient."""

from __future__ import annotations

from collections.abc import Mapping
from functools import lru_cache
from pathlib import Path
from typing import Any

from .errors import BadInput

FOLDER = Path(__file__).parent / "vessels"
REQUIRED = ("id", "title", "family", "source", "positive_rudder", "max_step_s", "parameters")
OPTIONAL = ("speed_m_s", "n0_rps", "particulars", "constants", "rudder", "controller", "windage", "suite")
NUMBER_KEYS = {"value", "unit", "source"}


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
    import yaml

    try:
        facts = yaml.safe_load(path.read_text(encoding="utf-8"))
    except yaml.YAMLError as error:
        raise BadInput(f"not a YAML file: {error}", file=path) from error
    if not isinstance(facts, dict):
        raise BadInput("not a vessel file", file=path)
    missing = [key for key in REQUIRED if key not in facts]
    unknown = [key for key in facts if key not in REQUIRED + OPTIONAL]
    if missing or unknown:
        said = f"missing: {', '.join(missing)}" if missing else f"unknown key: {', '.join(unknown)}"
        raise BadInput(said, file=path, hint=f"a vessel file has {', '.join(REQUIRED + OPTIONAL)}")
    if facts["id"] != path.stem:
        raise BadInput(f"id {facts['id']!r} differs from the file's name", file=path)
    if facts["positive_rudder"] not in ("port", "starboard"):
        raise BadInput("positive_rudder is port or starboard", file=path)
    for block in ("parameters", "constants", "particulars"):
        _check_numbers(facts.get(block) or {}, block, path)
    return facts


def _check_numbers(block: Mapping, name: str, path: Path) -> None:
    for key, entry in block.items():
        if not isinstance(entry, Mapping) or set(entry) != NUMBER_KEYS:
            raise BadInput(f"{name} {key}: needs value, unit and source, and nothing else", file=path)
        if isinstance(entry["value"], bool) or not isinstance(entry["value"], int | float):
            raise BadInput(
                f"{name} {key}: {entry['value']!r} is not a number", file=path, hint="write 1.0e-3, not 1e-3"
            )
