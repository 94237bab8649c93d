"""Results as JSON text."""

from __future__ import annotations

import json
from typing import Any


def json_text(value: Any) -> str:
    """A value as indented JSON; what is not a finite number is null."""
    from ..bench.store import plain

    return json.dumps(plain(value), indent=1, allow_nan=False)
