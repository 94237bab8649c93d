"""Two columns are exchanged."""

from __future__ import annotations

from typing import ClassVar

import numpy as np

from ._sensors import SensorKind, Stage
from .base import Setting


class ChannelSwap(SensorKind):
    """Two columns are exchanged."""

    id = "channel_swap"
    rank = 16
    units: ClassVar = {"channels": "pair"}
    whole = ("channels",)
    stage = Stage.COLUMN

    def draw(self, s: Setting, rng: np.random.Generator) -> dict[str, tuple[str, str]]:
        pairs = [("surge_m_s", "sway_m_s"), ("north_m", "east_m")]
        return {"channels": pairs[rng.integers(2)]}

    def apply(self, rows, time, p, noise_sd, rng) -> None:
        first, second = p["channels"]
        rows[first], rows[second] = rows[second], rows[first]
