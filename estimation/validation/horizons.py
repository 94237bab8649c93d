"""Times ahead at which predictions are compared with a record, from the ship's own time."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

if TYPE_CHECKING:
    from ...datasets.record import Record
    from ...models.model import Model

LENGTHS = (0.5, 1.5, 3.0)
"""Times ahead in ship lengths travelled: 10, 31 and 62 s for a ship of 160 m at 15 kn."""
SHARES = (1.0 / 60.0, 1.0 / 20.0, 1.0 / 10.0)
"""Times ahead as shares of the records' median duration where the ship's length or speed is not known."""
REFERENCE_S = 160.0 / (15.0 * 1852.0 / 3600.0)
"""L/U of a ship of 160 m at 15 kn, s."""


class Horizons(NamedTuple):
    """Times ahead in s, how they were chosen, and the ship's time as a multiple of that of a 160 m ship at 15 kn."""

    times_s: tuple[float, ...]
    basis: str
    clock: float


def horizons_of(models: Iterable[Model], records: Sequence[Record]) -> Horizons:
    """Horizons for all models alike: of the first one that knows its length; its speed may come from the records."""
    for model in models:
        length, speed = length_of(model), _speed(model, records)
        if np.isfinite(length) and np.isfinite(speed):
            own = length / speed
            source = "the model" if np.isfinite(model.speed_m_s) else "the records"
            times = ", ".join(f"{share:g}" for share in LENGTHS)
            basis = f"{times} ship lengths at L/U = {length:.4g} m / {speed:.3g} m/s = {own:.3g} s (speed of {source})"
            return Horizons(tuple(own * share for share in LENGTHS), basis, own / REFERENCE_S)
    duration = float(np.median([record.time_s[-1] - record.time_s[0] for record in records]))
    basis = (
        f"1/60, 1/20 and 1/10 of the records' median duration of {duration:.4g} s (no ship length or speed is known)"
    )
    return Horizons(tuple(duration * share for share in SHARES), basis, min(duration / 600.0, 1.0))


def length_of(model: Model) -> float:
    """The ship's length, m; nan where the model does not know it."""
    constants = dict(zip(model.constant_names, model.constants.tolist(), strict=True))
    return float(model.particulars.get("L", constants.get("L", np.nan)))


def _speed(model: Model, records: Sequence[Record]) -> float:
    """Speed of the straight course, m/s, else the median measured surge; nan where neither is known."""
    if np.isfinite(model.speed_m_s):
        return model.speed_m_s
    surge = [record.column("surge_m_s") for record in records if record.has("surge_m_s")]
    known = np.concatenate([np.zeros(0), *surge])
    known = np.abs(known[np.isfinite(known)])
    return float(np.median(known)) if known.size and np.median(known) > 0.0 else np.nan
