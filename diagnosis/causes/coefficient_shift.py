"""Cause `coefficient_shift`."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import TYPE_CHECKING

import numpy as np

from ...checks.result import Size
from ...estimation.filters.innovations.settings import Parameter
from ...models.families.extensions import EXTENSIONS
from ..searches.score import ByScore
from .base import Cause

if TYPE_CHECKING:
    from ...estimation.filters.innovations.estimator import Estimator
    from ...estimation.filters.innovations.settings import Setting
    from ..candidate import Variant

OF = "fraction of "
"""What the parameters' names start with; the coefficient follows."""


class CoefficientShift(Cause):
    """One coefficient of the base model differs by a fraction (`details` names it)."""

    id = "coefficient_shift"
    where = "hull"
    unit = "1"
    search = ByScore()
    power_size = 0.1
    separate_by = "a manoeuvre that excites the coefficient's own term"

    def stands_beside_numbers(self, is_3dof: bool) -> bool:
        return False

    def variants(self, est: Estimator) -> Sequence[Variant]:
        pairs = zip(est.model.coordinates, est.model.coefficients, strict=True)
        names = [n for n, c in pairs if c != 0.0 and n[1:] != "0"]
        public = _published_shifts(est) if est.model.kernels.PUBLISHED else []
        return public or [
            (Parameter(OF + n, "1", ((est.index[n], float(est.base[est.index[n]])),), scale=0.01, low=-0.95),)
            for n in names
        ]

    def details(self, est: Estimator, variant: Variant) -> Mapping[str, str]:
        return {"coefficient": variant[0].name.removeprefix(OF)}

    def sizes(
        self, est: Estimator, s: Setting, variant: Variant, covariance: np.ndarray, rng: np.random.Generator
    ) -> tuple[Size, ...]:
        (own,) = super().sizes(est, s, variant, covariance, rng)
        return (Size("fraction", own.value, own.low, own.high, own.unit, own.record),)


def _published_shifts(est: Estimator) -> list[Variant]:
    """Published parameters (K, T, ...) in the place of coefficients: one of them may move several."""
    model = est.model
    p0 = model.to_parameters(model.coefficients)
    if not np.isfinite(p0).all():
        return []
    slots = tuple((est.index[name], 1.0) for name in model.coordinates)

    def law(j: int) -> Callable[[float], np.ndarray]:
        def moved(fraction: float) -> np.ndarray:
            p = p0.copy()
            p[j] *= 1.0 + fraction
            return model.from_parameters(p) - model.coefficients

        return moved

    added = {name for extension in EXTENSIONS.values() for name in extension.units}
    return [
        (Parameter(OF + name, "1", slots, law=law(j), scale=0.01, low=-0.9, high=5.0),)
        for j, name in enumerate(model.parameter_names)
        if p0[j] != 0.0 and name not in added and name != "K"  # K is the rudder's effectiveness
    ]
