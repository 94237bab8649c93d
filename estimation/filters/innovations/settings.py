"""What the filter is run at: parameter vectors, noise, added series; and the parameters that move them."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace

import numpy as np


@dataclass(frozen=True)
class Noise:
    """Noise of the filter.

    sensor_sd : (6,) standard deviations of the channels, SI.
    force_sd : (nf,) standard deviations of the random forces, in force units.
    correlation_time_s : correlation time of the random forces.
    """

    sensor_sd: np.ndarray
    force_sd: np.ndarray
    correlation_time_s: float

    @property
    def has_forces(self) -> bool:
        """Whether any random force acts."""
        return bool(self.force_sd.any())

    def without_forces(self) -> Noise:
        """The same sensors, no random forces."""
        return replace(self, force_sd=np.zeros_like(self.force_sd))

    def equals(self, other: Noise) -> bool:
        """Whether all numbers are the same."""
        same = np.array_equal(self.sensor_sd, other.sensor_sd) and np.array_equal(self.force_sd, other.force_sd)
        return same and self.correlation_time_s == other.correlation_time_s


@dataclass(frozen=True)
class Parameter:
    """One number that can be estimated beside the noise.

    Parameters
    ----------
    name, unit : as results show them.
    slots : (entry of the parameter vector, weight) pairs; a value v adds v * weight to each entry.
    record : the record that it belongs to, None for all.
    low, high : physical bounds.
    scale : a small change of it.
    series : instead of slots, a time series that is added: axis (a force, or the number of forces + channel) and one
        array (T,) a segment.
    law : weight of each slot at a value, in place of value times weight; zero at zero.
    origin : what results add to a value: the number's own value where the effect is absent.
    """

    name: str
    unit: str
    slots: tuple[tuple[int, float], ...] = ()
    record: int | None = None
    low: float = -np.inf
    high: float = np.inf
    scale: float = 1e-3
    series: tuple[int, tuple[np.ndarray, ...]] | None = field(default=None, compare=False)
    law: Callable[[float], np.ndarray] | None = field(default=None, compare=False)
    origin: float = 0.0


@dataclass(frozen=True)
class Setting:
    """What the filter is run at.

    vectors : (S, NP) parameter vector of each segment.
    noise : of all segments.
    added : (T, nf + 6) arrays, one a segment, of forces (in force units) and sensor shifts; None for none.
    amounts : values of parameters that are no single entry of the vector (series and laws), by name.
    """

    vectors: np.ndarray
    noise: Noise
    added: tuple[np.ndarray, ...] | None = None
    amounts: Mapping[str, float] = field(default_factory=dict)
