"""Cause `constant_force`."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING

from ...estimation.filters.innovations.settings import Parameter
from ..searches.score import ByScore
from .base import Cause, NotTestable

if TYPE_CHECKING:
    from ...estimation.filters.innovations.estimator import Estimator
    from ..candidate import Variant


class ConstantForce(Cause):
    """Constant force in body axes, X and Y in N and N in N m (a towed sonar, a bent fin, asymmetric thrust)."""

    id = "constant_force"
    where = "hull"
    unit = "N, N m"
    search = ByScore()
    extension = "constant_force"
    separate_by = "straight runs at two speeds: a constant force does not grow with the speed"

    def variants(self, est: Estimator) -> Sequence[Variant]:
        if not est.model.is_3dof:
            raise NotTestable("in a response model a constant moment is a rudder offset")
        single = [
            Parameter(name, unit, ((est.index[f"constant_{name}"], 1.0),), scale=1e-6 * est.unit[i])
            for i, (name, unit) in enumerate((("X", "N"), ("Y", "N"), ("N", "N m")))
        ]
        return [*((p,) for p in single), tuple(single)]

    def details(self, est: Estimator, variant: Variant) -> Mapping[str, list[str]]:
        return {"components": [p.name for p in variant]}
