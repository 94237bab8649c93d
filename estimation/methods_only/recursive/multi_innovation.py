"""Multi-innovation updates: the last l innovations at once, as they are or through a sine (paper 004, eq 20-23)."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np

from ...regression.samples import RegressionSamples


@dataclass
class MultiInnovationRule:
    """A window of `length` samples, and omega of the sine for each equation.

    Without omega the innovations are taken as they are; as printed, one omega serves all equations.  The rule keeps
    the rows of the last samples: windows reach back over the ends of blocks and records.
    """

    length: int = 10
    omega: tuple[float, ...] = ()
    as_printed: bool = False
    window: tuple[np.ndarray, np.ndarray] | None = field(default=None, repr=False)
    """Rows (y, h) of the last length - 1 samples, which the next window still needs."""
    forgetting: float = field(default=1.0, init=False)

    @property
    def plain_covariance(self) -> bool:
        return self.as_printed

    @property
    def repetitions(self) -> float:
        """Every row is in `length` windows."""
        return float(self.length)

    def run(self, y, h, per_sample: int, theta, factor, diagonal, path) -> None:
        """As `recursion.UpdateRule.run`."""
        first = 0
        if self.window is not None:
            first = len(self.window[0])
            y, h = np.concatenate([self.window[0], y]), np.concatenate([self.window[1], h])
        if self.as_printed:
            from ._printed_kernels import multi_innovation_as_printed

            omega = self.omega[0]
            multi_innovation_as_printed(y, h, first, per_sample, self.length, omega, theta, factor, path)
        else:
            from ._innovation_kernels import multi_innovation

            omegas = np.array(self.omega, float)
            if omegas.size not in (0, per_sample):  # an equation without unknowns has been left out
                omegas = np.full(per_sample, omegas.max())
            multi_innovation(y, h, first, per_sample, self.length, omegas, theta, factor, diagonal, path)
        kept = min((self.length - 1) * per_sample, len(y))
        self.window = y[len(y) - kept :].copy(), h[len(y) - kept :].copy()


def one_step_share(parts: Sequence[RegressionSamples]) -> np.ndarray:
    """Root mean square (k,) of the change of each differentiated state over one sample, relative to the state's."""
    k = parts[0].accelerations.shape[1]
    change, size = np.zeros(k), np.zeros(k)
    for part in parts:
        if len(part.time_s) > 1:
            dt = float(np.median(np.diff(part.time_s)))
            change += ((part.accelerations * dt) ** 2).sum(axis=0)
            size += (part.states[:, :k] ** 2).sum(axis=0)
    return np.sqrt(np.maximum(change, 1e-300) / np.maximum(size, 1e-300))
