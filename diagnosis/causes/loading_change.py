"""Cause `loading_change`."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

from ..searches.score import ByScore
from .base import Cause, NotTestable, Number

if TYPE_CHECKING:
    from ...estimation.filters.innovations.estimator import Estimator
    from ..candidate import Variant


class LoadingChange(Cause):
    """Rigid-body mass and yaw inertia (with the centripetal terms they carry) differ by a common fraction."""

    id = "loading_change"
    where = "hull"
    unit = "1"
    search = ByScore()
    smallest = 0.01
    extension = "loading_change"
    power_size = 0.02
    separate_by = "the draught, or a stopping and a turning test at two loadings"
    number = Number("fraction", ("loading_fraction",), scale=0.01, low=-0.8, high=2.0)

    def variants(self, est: Estimator) -> Sequence[Variant]:
        if not est.model.is_3dof:
            raise NotTestable("a response model has no mass of its own: its time constants take it up")
        if not est.base[est.index["rigid_mass"]] > 0.0:
            raise NotTestable("the vessel file gives no displacement")
        return super().variants(est)
