"""Causes in what is about the ship: current, wind, drift by waves, and shallow water."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from ...checks.base import Prior
from ...checks.result import Size
from ...checks.sensors import CurrentDrift
from ...estimation.filters.innovations.settings import Parameter, Setting
from ..innovations.searches import ByRings, ByScore
from .base import DESCRIBED, Cause, NotTestable, require_3dof

if TYPE_CHECKING:
    from ...estimation.filters.innovations.estimator import Estimator
    from ..innovations.state import Variant

DRAWS = 2000
GRAVITY = 9.81
GROWING = {
    "abkowitz": ("Yv", "Nv", "Nr"),
    "mmg-son-nomoto": ("Yuv", "Nuv", "Nur"),
    "mmg": ("Y_v", "N_v", "N_r"),
    "mmg-fixed-speed": ("Yuv", "Nuv", "Nur"),
}
"""Family -> its linear damping coefficients of sway by sway, yaw by sway and yaw by yaw."""


class PairCause(Cause):
    """Base class of steady earth-fixed quantities that each record has its own of, told as size and direction.

    entries : names of the north and east number in the vector.  size_name, direction_name : of the sizes.
    coming_from : the direction is where it comes from, though the numbers say where to.
    """

    where = "environment"
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


class Current(CurrentDrift, PairCause):
    search, extension = ByRings((0.02, 0.1, 0.4)), "current"
    entries = ("current_towards_north", "current_towards_east")
    size_name, direction_name = "speed", "towards"
    smallest, power_size = 0.01, 0.05
    prior = Prior(0.1)


class Wind(PairCause):
    """Mean wind, earth-fixed and per record, on the vessel's windage; speed m/s and direction (rad) it blows from."""

    id, unit = "wind", "m/s, rad"
    search, extension = ByRings((3.0, 7.0, 13.0)), "wind"
    entries = ("wind_towards_north", "wind_towards_east")
    size_name, direction_name, coming_from = "speed", "from", True
    smallest, power_size, scale = 0.5, 3.0, 1.0
    prior = Prior(1.5)
    separate_by = "an anemometer, or the same manoeuvre on two headings and at two speeds"


class WaveDrift(PairCause):
    """Mean second-order wave force, per record: rho g Hs^2 L times coefficients of the encounter angle chi,
    CX = -.010 cos chi (times .3 in following seas), CY = -.020 sin chi |sin chi|, CN = -.002 sin 2 chi."""

    id, unit = "wave_drift", "m, rad"
    search, extension = ByRings((1e-5, 1e-4, 1e-3), by_clock=False), "wave_drift"
    entries = ("wave_drift_north", "wave_drift_east")
    size_name, direction_name, scale = "Hs", "from", 1.0
    separate_by = "a wave buoy, or the same manoeuvre on two headings"
    beside_numbers = False

    def amount(self, est: Estimator) -> Callable[[float], float]:
        """Significant wave height (m) of a drift force rho g Hs^2 L (N)."""
        p = est.model.particulars
        weight = p.get("rho", 1025.0) * GRAVITY * p.get("L", 1.0)
        return lambda force: float(np.sqrt(max(force, 0.0) / weight))


class ShallowWater(Cause):
    """Depth over draught h/d: Y_v, N_v and N_r grow as in Hirano et al. 1985 (Inoue's formulas with the effective
    aspect ratio k_e = k/(d k/(2 h) + (x cot x)^q), x = pi d/(2 h), q = 2.3, 1.7, .7)."""

    id, where, unit = "shallow_water", "environment", "1"
    search = ByScore((0.05, 0.1, 0.2, 0.4, 0.6, 0.8))
    smallest = 0.2
    separate_by = "an echo sounder, or the same manoeuvre in deep water"

    @property
    def describes_hull(self) -> bool:
        return True

    def variants(self, est: Estimator) -> Sequence[Variant]:
        names = GROWING.get(est.model.family.split("+")[0])
        p = est.model.particulars
        if names is None or not {"L", "d", "nabla"} <= set(p):
            raise NotTestable("stated for 3-DOF models with L, d and displacement only")
        slots = tuple((est.index[name], float(est.base[est.index[name]])) for name in names)

        def growth(inverse: float) -> np.ndarray:
            return shallow_factors(p["L"], p["d"], p["nabla"], inverse) - 1.0

        return [(Parameter("draught_over_depth", "1", slots, law=growth, low=0.0, high=0.9, scale=0.05),)]

    def sizes(
        self, est: Estimator, s: Setting, variant: Variant, covariance: np.ndarray, rng: np.random.Generator
    ) -> tuple[Size, ...]:
        """Depth over draught, from the interval of its inverse."""
        (own,) = super().sizes(est, s, variant, covariance, rng)
        value, low, high = (1.0 / max(x, 1e-3) for x in (own.value, own.high, own.low))
        return (replace(own, parameter="depth_ratio", value=value, low=low, high=high),)


def shallow_factors(length: float, draught: float, nabla: float, inverse: float) -> np.ndarray:
    """(3,) Y_v, N_v, N_r at draught over depth `inverse`, over those in deep water (Hirano et al. 1985)."""
    if inverse <= 0.0:
        return np.ones(3)
    k, x = 2.0 * draught / length, 0.5 * np.pi * inverse
    ke = k / (0.5 * k * inverse + (x / np.tan(x)) ** np.array([2.3, 1.7, 0.7]))
    block = 1.4 * nabla / (length**2 * draught)
    sway = (0.5 * np.pi * ke[0] + block) / (0.5 * np.pi * k + block)
    return np.array([sway, ke[1] / k, (0.54 * ke[2] - ke[2] ** 2) / (0.54 * k - k**2)])
