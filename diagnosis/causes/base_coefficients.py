"""Causes in the base model's own numbers: all of them, one coefficient, mass and inertia together, or its size."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import TYPE_CHECKING

import numpy as np

from ...checks.base import Prior
from ...checks.result import Size
from ...estimation.filters.innovations.settings import Parameter
from ...models.families.extensions import extensions
from ..innovations.searches import ByScore
from .base import Cause, NotTestable, Number, StageCause, require_3dof

if TYPE_CHECKING:
    from ...estimation.filters.innovations.estimator import Estimator
    from ...estimation.filters.innovations.settings import Setting
    from ..innovations.state import Variant

OF = "fraction of "
"""What the parameters' names start with; the coefficient follows."""


class ShipScale(StageCause):
    """Records of a similar ship of another size, 1 + k times as long as the model's, after Froude: lengths go with the
    scale, times and speeds with its square root, rates and revolutions with the inverse of that."""

    id, where, stage = "ship_scale", "sampling", "looked for by free runs of the model"
    number = Number("k", ("ship_scale",), scale=0.01, low=-0.95, high=100.0)
    prior = Prior(0.3, needs=("u", "r"), last=True)
    separate_by = "length and speed of the ship that the records are of"


class BaseCoefficients(StageCause):
    """Numbers of the base model are wrong: groups of coefficients and constants that the family states, such as the
    propeller's thrust or the resistance, moved within their priors."""

    id, where = "base_coefficients", "hull"
    stage = "looked for by free runs of records that were left out, where the base model leaves effects unexplained"
    separate_by = "runs that vary one thing at a time: speed on a straight course, rudder angle at one speed"


class LoadingChange(Cause):
    """Rigid-body mass and yaw inertia (with the centripetal terms they carry) differ by a common fraction."""

    id, where, unit = "loading_change", "hull", "1"
    search, extension = ByScore(), "loading_change"
    number = Number("fraction", ("loading_fraction",), scale=0.01, low=-0.8, high=2.0)
    smallest, power_size = 0.01, 0.02
    separate_by = "the draught, or a stopping and a turning test at two loadings"

    def variants(self, est: Estimator) -> Sequence[Variant]:
        require_3dof(est, "a response model has no mass of its own: its time constants take it up")
        if not est.base[est.index["rigid_mass"]] > 0.0:
            raise NotTestable("the vessel file gives no displacement")
        return super().variants(est)


class CoefficientShift(Cause):
    """One coefficient of the base model differs by a fraction (`details` names it)."""

    id, where, unit = "coefficient_shift", "hull", "1"
    search = ByScore()
    power_size = 0.1
    separate_by = "a manoeuvre that excites the coefficient's own term"
    beside_numbers = False

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

    added = {name for extension in extensions().values() for name in extension.units}
    return [
        (Parameter(OF + name, "1", slots, law=law(j), scale=0.01, low=-0.9, high=5.0),)
        for j, name in enumerate(model.parameter_names)
        if p0[j] != 0.0 and name not in added and name != "K"  # K is the rudder's effectiveness
    ]
