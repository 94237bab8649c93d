"""The rudder columns of a record."""

from __future__ import annotations

from ....datasets.columns import RUDDERS
from .base import Rows


def rudder_columns(rows: Rows) -> list[str]:
    """Names of the rudder columns that are there."""
    return [name for name in RUDDERS if name in rows]
