"""Further cross-flow terms of sway velocity and yaw rate: r|v| and v|r| in sway force and yaw moment."""

from __future__ import annotations

import numpy as np

from .base import EffectKind, Setting, damping_size


class CrossflowCoupling(EffectKind):
    """Further cross-flow terms of sway velocity and yaw rate: r|v| and v|r| in sway force and yaw moment."""

    id = "crossflow_coupling"
    rank = 28
    sized = ("Yrv", "Yvr", "Nvr", "Nrv")
    units = dict.fromkeys(sized, "1")

    def draw(self, s: Setting, rng: np.random.Generator) -> dict[str, float]:
        size = damping_size(s.ship)
        draws = -size * rng.uniform(0.3, 1.5, 4) * np.array([4.0, 4.0, 1.0, 1.0])
        return dict(zip(self.sized, map(float, draws), strict=True))

    def forces(self, p) -> dict[str, float]:
        return dict(p)
