"""Terms that a model lacks, as forces along the measured motion, in the units of the extension's parameter.

    Y' = a v'|v'|,  N' = a r'|r'|, ... ;   F = F' rho/2 A U^2,  N = N' rho/2 A L U^2,  A = L d where the family knows d

as `models.families.extensions` has them along the simulated motion.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import TYPE_CHECKING

import numpy as np

from ...datasets.signals import bridged

if TYPE_CHECKING:
    from ...models.model import Model
    from .units import Unit

FORMULAS: Mapping[str, Callable[[np.ndarray, np.ndarray], np.ndarray]] = {
    "added_Nr_absr": lambda v, r: r * abs(r),
    "added_Nrrr": lambda v, r: r**3,
    "added_Yv_absv": lambda v, r: v * abs(v),
    "added_Yr_absv": lambda v, r: r * abs(v),
    "added_Yv_absr": lambda v, r: v * abs(r),
    "added_Nv_absr": lambda v, r: v * abs(r),
    "added_Nr_absv": lambda v, r: r * abs(v),
}
"""Parameter -> its factor in the prime system, of v' = v/U and r' = r L/U."""


def term_series(model: Model, unit: Unit, name: str, smooth_s: float) -> np.ndarray:
    """Force, N, or moment, N m, (M + 1,) on the unit's grid for a parameter of one, along motion smoothed over
    smooth_s."""
    series, numbers = unit.stretch.series, model.environment_numbers()
    time_s = unit.stretch.record.time_s
    width = max(1, int(smooth_s / series.dt) | 1)

    def smoothed(symbol: str, otherwise: float) -> np.ndarray:
        values = unit.measured([symbol])[:, 0]
        if not np.isfinite(values).any():
            return np.full(len(unit.grid_s), otherwise)
        on_grid = np.interp(unit.grid_s, time_s, bridged(values, time_s))
        padded = np.pad(on_grid, width // 2, "edge")
        return np.convolve(padded, np.full(width, 1.0 / width), "valid")

    u, v = smoothed("u", model.speed_m_s), smoothed("v", 0.0)
    r = smoothed("r", np.nan)
    if not np.isfinite(r).all():
        r = np.gradient(smoothed("psi", 0.0), series.dt)
    length = numbers.get("L", numbers["wind_L"])
    area = length * numbers.get("d", length)
    speed = np.sqrt(u**2 + v**2 + 1e-12)
    pressure = 0.5 * numbers["rho"] * area * speed**2 * (length if name.startswith("added_N") else 1.0)
    return pressure * FORMULAS[name](v / speed, r * length / speed)
