"""What causes in response models share."""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from ...estimation.filters.innovations.estimator import Estimator


def yaw_weight(est: Estimator) -> float:
    """What turns alpha of T r_dot + r + alpha d(r) = K delta into a term of the highest derivative; 1 for 3-DOF."""
    if est.model.is_3dof:
        return 1.0
    c = dict(zip(est.model.coordinates, est.model.coefficients, strict=True))
    return float(c.get("a2", c.get("a", -1.0)))
