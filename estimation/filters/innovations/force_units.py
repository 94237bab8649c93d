"""Units in which the filter counts random forces."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from ....models.model import Model
    from .segments import Segment


def force_units(model: Model, segments: Sequence[Segment]) -> np.ndarray:
    """Units (nf,) of the forces: rho L^2 U0^2 / 2 (times L), or a typical yaw acceleration for response models."""
    if model.is_3dof:
        length, rho = model.particulars.get("L", 1.0), model.particulars.get("rho", 1025.0)
        pressure = 0.5 * rho * length**2 * model.speed_m_s**2
        return np.array([pressure, pressure, pressure * length])
    slopes = []
    for d in segments:
        rate = d.measured[:, 1] if np.isfinite(d.measured[:, 1]).any() else np.gradient(d.measured[:, 0], d.time)
        window = max(2, d.time.size // 100)
        rise = (rate[window:] - rate[:-window]) / (d.time[window:] - d.time[:-window])
        slopes.append(np.sqrt(np.mean(rise[np.isfinite(rise)] ** 2)) if np.isfinite(rise).any() else 0.0)
    typical = 6000.0 * max(float(np.median(slopes)), 1e-9)
    return np.array([typical] if "w" not in model.states else [typical / max(_fast_time(model), 1e-3), typical])


def _fast_time(model: Model) -> float:
    """A second-order response model's shorter time constant: forces on its highest derivative count against it."""
    a1 = model.coefficients[0]
    return 1.0 / max(abs(a1), 1e-6) if np.isfinite(a1) else 1.0
