"""Cause `shallow_water`."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from ...checks.result import Size
from ...estimation.filters.innovations.settings import Parameter
from ..searches.score import ByScore
from .base import Cause, NotTestable

if TYPE_CHECKING:
    from ...estimation.filters.innovations.estimator import Estimator
    from ...estimation.filters.innovations.settings import Setting
    from ..candidate import Variant

GROWING = {
    "abkowitz": ("Yv", "Nv", "Nr"),
    "mmg-son-nomoto": ("Yuv", "Nuv", "Nur"),
    "mmg": ("Y_v", "N_v", "N_r"),
    "mmg-fixed-speed": ("Yuv", "Nuv", "Nur"),
}
"""Family -> its linear damping coefficients of sway by sway, yaw by sway and yaw by yaw."""


class ShallowWater(Cause):
    """Depth over draught h/d: Y_v, N_v and N_r grow as in Hirano et al. 1985 (Inoue's formulas with the effective
    aspect ratio k_e = k/(d k/(2 h) + (x cot x)^q), x = pi d/(2 h), q = 2.3, 1.7, .7)."""

    id = "shallow_water"
    where = "environment"
    unit = "1"
    search = ByScore((0.05, 0.1, 0.2, 0.4, 0.6, 0.8))
    smallest = 0.2
    separate_by = "an echo sounder, or the same manoeuvre in deep water"

    @property
    def describes_hull(self) -> bool:
        return True

    def variants(self, est: Estimator) -> Sequence[Variant]:
        names = GROWING.get(est.model.family.split("+")[0])
        p = est.model.particulars
        if names is None or not {"L", "d", "nabla"} <= set(p):
            raise NotTestable("stated for 3-DOF models with L, d and displacement only")
        slots = tuple((est.index[name], float(est.base[est.index[name]])) for name in names)

        def growth(inverse: float) -> np.ndarray:
            return shallow_factors(p["L"], p["d"], p["nabla"], inverse) - 1.0

        return [(Parameter("draught_over_depth", "1", slots, law=growth, low=0.0, high=0.9, scale=0.05),)]

    def sizes(
        self, est: Estimator, s: Setting, variant: Variant, covariance: np.ndarray, rng: np.random.Generator
    ) -> tuple[Size, ...]:
        """Depth over draught, from the interval of its inverse."""
        (own,) = super().sizes(est, s, variant, covariance, rng)
        value, low, high = (1.0 / max(x, 1e-3) for x in (own.value, own.high, own.low))
        return (replace(own, parameter="depth_ratio", value=value, low=low, high=high),)


def shallow_factors(length: float, draught: float, nabla: float, inverse: float) -> np.ndarray:
    """(3,) Y_v, N_v, N_r at draught over depth `inverse`, over those in deep water (Hirano et al. 1985)."""
    if inverse <= 0.0:
        return np.ones(3)
    k, x = 2.0 * draught / length, 0.5 * np.pi * inverse
    ke = k / (0.5 * k * inverse + (x / np.tan(x)) ** np.array([2.3, 1.7, 0.7]))
    block = 1.4 * nabla / (length**2 * draught)
    sway = (0.5 * np.pi * ke[0] + block) / (0.5 * np.pi * k + block)
    return np.array([sway, ke[1] / k, (0.54 * ke[2] - ke[2] ** 2) / (0.54 * k - k**2)])
