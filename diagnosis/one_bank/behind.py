"""Records as the hull made them: without what causes that are none of the hull's explain."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from ...datasets.instruments import corrected
from ...estimation.records.weather import CURRENT, WIND, flow_of
from .catalogue import OFFSET, SIDES, flow_name

if TYPE_CHECKING:
    from ...datasets.record import Record
    from ...estimation.selection.number import Candidate
    from .search import Choice

MEASURED_AS = {"current": CURRENT, "wind": WIND}
"""Flow -> columns that it is measured in."""


def behind_causes(choice: Choice, records: Sequence[Record]) -> list[Record]:
    """Records without the errors of rudder and sensors that a choice holds, and with its current and wind among what
    was measured; a neutral angle, and what belongs to single records, stay in them."""
    instruments = instruments_behind(choice)
    return [in_flows(corrected(record, instruments), choice) for record in records]


def instruments_behind(choice: Choice) -> dict[str, float]:
    """Instruments of rudder and sensors that a choice says all records have, without a neutral angle."""
    return instruments_of(choice, [c for c in choice.selection.candidates if c.of != OFFSET])


def instruments_of(choice: Choice, candidates: Sequence[Candidate], record: int | None = None) -> dict[str, float]:
    """Instruments of rudder and sensors that some candidates say all records have, and the record of a number."""
    instruments: dict[str, float] = {}
    for name in (name for c in candidates for name in c.names):
        place, value = choice.bank.places[name], choice.selection.final.value(name)
        if place.kind in ("steering", "sensor") and place.record in (None, record) and value:
            instruments |= {entry: 1.0 / value if place.inverse else value for entry in place.entries}
            instruments |= dict(place.fixed)
    return instruments


def in_flows(record: Record, choice: Choice) -> Record:
    """The record with the current and wind of a choice added to what it measures of them."""
    final, channels = choice.selection.final, {}
    for name, columns in MEASURED_AS.items():
        own = np.array([final.point.values.get(flow_name(name, side, None), 0.0) for side in SIDES])
        if not own.any():
            continue
        measured = flow_of(record, columns)
        total = np.tile(own, (record.n, 1))
        if measured is not None:
            total += np.column_stack([np.interp(record.time_s, measured[0], v) for v in measured[1].T])
        total *= columns[2]
        channels |= {columns[0]: np.hypot(*total.T), columns[1]: np.arctan2(total[:, 1], total[:, 0])}
    return record.with_channels(**channels)
