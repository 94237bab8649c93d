"""Quantities with a direction: (north, east) pairs, one a record, told as size and direction."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING

import numpy as np

from ...checks.result import Size
from ...estimation.filters.innovations.settings import Parameter, Setting
from .base import DESCRIBED, Cause, require_3dof

if TYPE_CHECKING:
    from ...estimation.filters.innovations.estimator import Estimator
    from ..candidate import Variant

DRAWS = 2000


class PairCause(Cause):
    """Base class of steady earth-fixed quantities that each record has its own of.

    entries : names of the north and east number in the vector.  size_name, direction_name : of the sizes.
    coming_from : the direction is where it comes from, though the numbers say where to.
    """

    entries: tuple[str, str]
    size_name: str
    direction_name: str
    coming_from = False
    scale = 0.01

    def variants(self, est: Estimator) -> Sequence[Variant]:
        require_3dof(est)
        names = (self.size_name, self.direction_name)
        return [
            tuple(
                Parameter(name, self.unit.partition(",")[0], ((est.index[entry], 1.0),), record=i, scale=self.scale)
                for i in range(est.n_records)
                for name, entry in zip(names, self.entries, strict=True)
            )
        ]

    def amount(self, est: Estimator) -> Callable[[float], float]:
        """What the length of a pair is told as."""
        return lambda length: length

    def sizes(
        self, est: Estimator, s: Setting, variant: Variant, covariance: np.ndarray, rng: np.random.Generator
    ) -> tuple[Size, ...]:
        """Size and direction of each record's pair, from draws of its components."""
        values, amount = np.array([est.value(s, p) for p in variant]), self.amount(est)
        sign = -1.0 if self.coming_from else 1.0
        out = []
        for i in range(0, len(variant), 2):
            pair = values[i : i + 2]
            block = covariance[i : i + 2, i : i + 2] + DESCRIBED**2 * (pair @ pair) * np.eye(2)
            draws = pair + rng.multivariate_normal(np.zeros(2), block, DRAWS, method="eigh")
            direction = float(np.arctan2(sign * pair[1], sign * pair[0]))
            turned = np.arctan2(sign * draws[:, 1], sign * draws[:, 0]) - direction
            low, high = np.quantile(np.mod(turned + np.pi, 2.0 * np.pi) - np.pi, [0.05, 0.95])
            length = float(np.hypot(*pair))
            along = draws @ pair / max(length, 1e-300)
            ends = [amount(float(x)) for x in np.maximum(np.quantile(along, [0.05, 0.95]), 0.0)]
            name = None if variant[i].record is None else est.record_names[variant[i].record or 0]
            out.append(Size(self.size_name, amount(length), ends[0], ends[1], variant[i].unit, name))
            out.append(Size(self.direction_name, direction, direction + low, direction + high, "rad", name))
        return tuple(out)
