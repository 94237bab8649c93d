"""The YAML sidecar of a record: metadata, and the channels that are constant on purpose."""

from __future__ import annotations

import os
from collections.abc import Mapping
from dataclasses import fields
from pathlib import Path
from typing import Any

import numpy as np

from ..models.errors import BadInput
from .columns import CANONICAL
from .files import read_utf8
from .record import RecordMeta, is_side

META_KEYS = tuple(f.name for f in fields(RecordMeta) if f.name != "extra")


def sidecar_path(path: str | os.PathLike[str]) -> Path:
    """The sidecar of a record file: same stem, ``.yaml`` (``.yml`` where only that exists)."""
    path = Path(path)
    short = path.with_suffix(".yml")
    return short if short.exists() and not path.with_suffix(".yaml").exists() else path.with_suffix(".yaml")


def read_sidecar(path: Path) -> tuple[RecordMeta, frozenset[str]]:
    """(metadata, channels declared constant), both empty where there is no such file.

    Known keys are those of `RecordMeta` and ``constant`` (a channel name or a list of them); all others are kept in
    `RecordMeta.extra`. BadInput: not YAML, not a mapping, a side or a channel that does not exist.
    """
    if not path.exists():
        return RecordMeta(), frozenset()
    content, rows = _load_yaml(path)
    known = {_key(key): value for key, value in content.items() if _key(key) in (*META_KEYS, "constant")}
    extra = {str(key): value for key, value in content.items() if _key(key) not in known}
    constant = _constant(known.pop("constant", None), path, rows.get("constant"))
    texts: dict[str, Any] = {key: _text(value, key, path, rows.get(key)) for key, value in known.items()}
    side = texts.get("positive_rudder")
    if side is not None and not is_side(side):
        row = rows["positive_rudder"]
        raise BadInput(f"positive_rudder is {side!r}", file=path, row=row, hint="give port or starboard")
    return RecordMeta(**texts, extra=extra), constant


def sidecar_text(meta: RecordMeta, constant: list[str]) -> str:
    """The sidecar's text: what is known, then the channels that are constant, then the extra keys."""
    import yaml

    content = {key: getattr(meta, key) for key in META_KEYS if getattr(meta, key) is not None}
    content |= {"constant": constant} if constant else {}
    content |= {key: value for key, value in meta.extra.items() if _key(key) not in (*META_KEYS, "constant")}
    return yaml.safe_dump(_plain(content), sort_keys=False, allow_unicode=True, width=110)


def _key(key: object) -> str:
    return str(key).strip().lower().replace(" ", "_").replace("-", "_")


def _load_yaml(path: Path) -> tuple[dict[Any, Any], dict[str, int]]:
    """(the mapping, line of each key)."""
    import yaml

    data = read_utf8(path).decode()
    try:
        node = yaml.compose(data, Loader=yaml.SafeLoader)
        content = yaml.safe_load(data)
    except (yaml.YAMLError, ValueError) as error:
        mark = getattr(error, "problem_mark", None) or getattr(error, "context_mark", None)
        reason = getattr(error, "problem", None) or str(error)
        raise BadInput(f"not YAML ({reason})", file=path, row=mark.line + 1 if mark else None) from None
    if content is None:
        return {}, {}
    if not isinstance(content, dict) or not isinstance(node, yaml.MappingNode):
        raise BadInput("metadata must be 'key: value' lines", file=path, row=1)
    return content, {_key(key.value): key.start_mark.line + 1 for key, _ in node.value}


def _text(value: object, key: str, path: Path, row: int | None) -> str | None:
    if isinstance(value, list | dict):
        raise BadInput(f"{key} must be a text", file=path, row=row)
    return None if value is None else str(value)


def _constant(value: object, path: Path, row: int | None) -> frozenset[str]:
    names = [] if value is None else [str(name) for name in (value if isinstance(value, list) else [value])]
    for name in names:
        if name not in CANONICAL:
            raise BadInput(f"constant: {name!r} is not a channel", file=path, row=row, hint=", ".join(CANONICAL))
    return frozenset(names)


def _plain(value: Any) -> Any:
    """Nested containers with NumPy values turned into Python's own, as YAML needs them."""
    if isinstance(value, Mapping):
        return {str(key): _plain(item) for key, item in value.items()}
    if isinstance(value, list | tuple):
        return [_plain(item) for item in value]
    return value.tolist() if isinstance(value, np.ndarray | np.generic) else value
