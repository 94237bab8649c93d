"""The YAML sidecar of a record: metadata, and the channels that are constant on purpose."""

from __future__ import annotations

import os
from collections.abc import Mapping
from dataclasses import fields
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from ..models.data_file import MOST_YAML_BYTES, yaml_of
from ..models.errors import BadInput
from ..models.files import read_utf8
from .record import RecordMeta

if TYPE_CHECKING:
    pass

META_KEYS = tuple(f.name for f in fields(RecordMeta) if f.name != "extra")


def sidecar_path(path: str | os.PathLike[str]) -> Path:
    """The sidecar of a record file: same stem, ``.yaml`` (``.yml`` where only that exists)."""
    path = Path(path)
    short = path.with_suffix(".yml")
    return short if short.exists() and not path.with_suffix(".yaml").exists() else path.with_suffix(".yaml")


def refuse_to_replace(path: Path) -> None:
    """BadInput where a YAML file that is no sidecar, such as a vessel's, lies in a sidecar's place."""
    if not path.is_file():
        return
    try:
        content, _ = yaml_of(read_utf8(path, MOST_YAML_BYTES), path)
    except BadInput:  # a damaged sidecar
        return
    if isinstance(content, dict) and {_key(key) for key in content} - {*META_KEYS, "constant", "extra"}:
        hint = "give the record another name"
        raise BadInput("is no sidecar of a record and would be replaced by one", file=path, hint=hint)


def read_sidecar(path: Path) -> tuple[RecordMeta, frozenset[str]]:
    """(metadata, channels declared constant), both empty where there is no such file.

    Known keys are those of `RecordMeta` and ``constant`` (a channel name or a list of them); whatever else is to be
    kept stands below the key ``extra``. BadInput: not YAML, not a mapping, an unknown key, a side or a channel that
    does not exist.
    """
    if not path.exists():
        return RecordMeta(), frozenset()
    content, rows = yaml_of(read_utf8(path, MOST_YAML_BYTES), path)
    if content is None:
        return RecordMeta(), frozenset()
    if not isinstance(content, dict):
        raise BadInput("metadata must be 'key: value' lines", file=path, row=1)
    given = {_key(key): value for key, value in content.items()}
    if len(given) < len(content):
        raise BadInput("a key stands twice, in two spellings", file=path, row=max(rows.values()))
    from ..models.yaml_file import checked
    from .sidecar_file import SidecarFile

    places = {_key(key): row for key, row in rows.items()}
    for key, value in given.items():  # key by key, so that the message can name the row
        try:
            checked(SidecarFile, {key: value}, path)
        except BadInput as error:
            raise BadInput(error.message, file=path, row=places.get(key), hint=error.hint) from None
    facts = checked(SidecarFile, given, path)
    texts: dict[str, Any] = {key: getattr(facts, key) for key in META_KEYS}
    return RecordMeta(**texts, extra=facts.extra or {}), frozenset(facts.constant)


def sidecar_text(meta: RecordMeta, constant: list[str]) -> str:
    """The sidecar's text: what is known, then the channels that are constant, then what else is kept."""
    import yaml

    content = {key: getattr(meta, key) for key in META_KEYS if getattr(meta, key) is not None}
    content |= {"constant": constant} if constant else {}
    content |= {"extra": meta.extra} if meta.extra else {}
    return yaml.safe_dump(_plain(content), sort_keys=False, allow_unicode=True, width=110)


def _key(key: object) -> str:
    return str(key).strip().lower().replace(" ", "_").replace("-", "_")


def _plain(value: Any) -> Any:
    """Nested containers with NumPy values turned into Python's own, as YAML needs them."""
    if isinstance(value, Mapping):
        return {str(key): _plain(item) for key, item in value.items()}
    if isinstance(value, list | tuple):
        return [_plain(item) for item in value]
    return value.tolist() if isinstance(value, np.ndarray | np.generic) else value
