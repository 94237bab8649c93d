"""Effects injected in measured records: what the sensors or the rudder channel could have got wrong."""

from __future__ import annotations

from typing import Any

import numpy as np

from ...datasets.record import Record
from ...models.errors import BadInput
from .effects import kind_of, kinds
from .effects.base import RecordEffect


def inject_in_record(record: Record, cause: str, parameters: dict[str, Any], rng: np.random.Generator) -> Record:
    """The record as it would read under an effect of the sensors or the rudder channel, with gaps where a delayed
    channel has no value.  `BadInput` for another effect or a missing channel."""
    kind = kind_of(cause)
    if not isinstance(kind, RecordEffect):
        able = ", ".join(name for name, known in kinds().items() if isinstance(known, RecordEffect))
        raise BadInput(f"{cause} cannot be injected in a measured record", hint=f"{able} can")
    columns = {name: record.column(name).copy() for name in record.channels}
    if "heading_rad" in columns:
        columns["heading_rad"] = record.heading_unwrapped().copy()
    try:
        kind.change_record(columns, record.time_s, parameters, rng)
    except KeyError as error:
        raise BadInput(f"{cause} needs the column {error}", file=record.name) from None
    return record.with_channels(**columns)
