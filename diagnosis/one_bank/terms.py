"""Terms that a model lacks, as forces along the measured motion, in the units of the extension's parameter.

    Y' = a v'|v'|,  N' = a r'|r'|, ... ;   F = F' rho/2 A U^2,  N = N' rho/2 A L U^2,  A = L d where the family knows d

as `models.families.extensions` has them along the simulated motion.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from ..free_runs.motion import Motion, Series

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


def term_of(name: str) -> Series:
    """Force, N, or moment, N m, along a motion for a parameter of one."""
    formula = FORMULAS[name]

    def along(motion: Motion) -> np.ndarray:
        return motion.unit(name.removeprefix("added_")[0]) * formula(motion.v, motion.r)

    return along
