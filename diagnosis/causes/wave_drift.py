"""Cause `wave_drift`."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING

import numpy as np

from ..searches.score import ByRings
from ._pairs import PairCause

if TYPE_CHECKING:
    from ...estimation.filters.innovations.estimator import Estimator

GRAVITY = 9.81


class WaveDrift(PairCause):
    """Mean second-order wave force, per record: rho g Hs^2 L times coefficients of the encounter angle chi,
    CX = -.010 cos chi (times .3 in following seas), CY = -.020 sin chi |sin chi|, CN = -.002 sin 2 chi."""

    id = "wave_drift"
    where = "environment"
    unit = "m, rad"
    search = ByRings((1e-5, 1e-4, 1e-3), by_clock=False)
    extension = "wave_drift"
    separate_by = "a wave buoy, or the same manoeuvre on two headings"
    entries = ("wave_drift_north", "wave_drift_east")
    size_name, direction_name, coming_from = "Hs", "from", False
    scale = 1.0

    def stands_beside_numbers(self, is_3dof: bool) -> bool:
        return False

    def amount(self, est: Estimator) -> Callable[[float], float]:
        """Significant wave height (m) of a drift force rho g Hs^2 L (N)."""
        p = est.model.particulars
        weight = p.get("rho", 1025.0) * GRAVITY * p.get("L", 1.0)
        return lambda force: float(np.sqrt(max(force, 0.0) / weight))
