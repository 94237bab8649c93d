"""A share of every channel's samples has gross errors of 12 to 30 standard deviations."""

from __future__ import annotations

import numpy as np

from ....datasets.columns import RUDDERS
from ..ships import Ship
from ._sensors import SensorKind, Stage
from .base import ScalarKind


class Outliers(ScalarKind, SensorKind):
    """A share of every channel's samples has gross errors of 12 to 30 standard deviations."""

    id = "outliers"
    rank = 18
    parameter, unit = "share", "1"
    negative = 0.0
    cap = 0.1
    variance_only = True
    response = True
    stage = Stage.GROSS_ERROR

    def size(self, ship: Ship) -> float:
        return 0.005

    def noncentrality(self, p) -> float:
        return p["share"] * 12e4

    def apply(self, rows, time, p, noise_sd, rng) -> None:
        for name in [name for name in rows if name not in RUDDERS]:
            n = rows[name].size
            error = rng.choice([-1.0, 1.0], n) * rng.uniform(12.0, 30.0, n) * noise_sd.get(name, 0.0)
            rows[name] = rows[name] + np.where(rng.random(n) < p["share"], error, 0.0)

    def change_record(self, rows, time, p, rng) -> None:
        """A measured channel's own noise is taken from its third differences."""
        spread = {name: np.nanmedian(np.abs(np.diff(values, 3))) for name, values in rows.items()}
        self.apply(rows, time, p, {name: 1.4826 * value / np.sqrt(20.0) for name, value in spread.items()}, rng)
