"""Values as JSON takes them."""

from __future__ import annotations

import json
import math
from collections.abc import Mapping
from dataclasses import fields, is_dataclass
from typing import Any

EXACT_BELOW = 2**53
"""Whole numbers below it are exact as floating-point numbers too, as which some readers take them."""
AS_THEY_ARE = frozenset({str, int, bool, type(None)})


def json_text(value: Any) -> str:
    """A value as indented JSON; what is not a finite number is null."""
    return json.dumps(plain(value), indent=1, allow_nan=False)


def plain(value: Any) -> Any:
    """Built-in types only: arrays become lists, dataclasses mappings, and what is not a finite number null."""
    if type(value) in AS_THEY_ARE:
        return value
    if type(value) is float:
        return value if math.isfinite(value) else None
    if isinstance(value, Mapping):
        return {str(key): plain(item) for key, item in value.items()}
    if isinstance(value, list | tuple | set | frozenset):
        return [plain(item) for item in value]
    if hasattr(value, "tolist"):
        return plain(value.tolist())
    if is_dataclass(value):
        return {field.name: plain(getattr(value, field.name)) for field in fields(value)}
    if isinstance(value, float) and not math.isfinite(value):
        return None
    return value
