"""Tables I and II over what paper 002 does not print: the noise, the steering gear, the unit of angles."""

from __future__ import annotations

import numpy as np

from ...claims.files import load
from ..study import StudyResult, point
from .studies import DURATION_S, PRINTED, STEP_S, printed_first, printed_second, table, zigzag

FORMS = {"first_order": ("response-1", printed_first), "second_order": ("response-2", printed_second)}


def over_range(order: str, rng: np.random.Generator, *, index: int) -> StudyResult:
    """Run `index` of the search of an order; its noise belongs to the point, not to the seed."""
    chosen = point(load("002").search(f"{order}_searched"), index)
    name, printed = FORMS[order]
    draw = np.random.default_rng(index).normal(size=round(DURATION_S / STEP_S))
    noise = np.deg2rad(chosen["noise on the right side"]) * draw
    record = zigzag(name, noise, np.deg2rad(chosen["rudder rate"]), chosen["rudder lag"])
    form = PRINTED if chosen["angles in"] == "degrees" else PRINTED.replace("degrees=true", "degrees=false")
    return StudyResult(table(name, printed, record, form).values)
