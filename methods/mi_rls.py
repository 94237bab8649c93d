"""MI-RLS: recursive least squares that takes the last l innovations at once (paper 004, eq 20)."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import ClassVar

import numpy as np

from ..models.errors import BadInput
from .rls import Rls, Setting
from .tuning.space import Integer, Real


@dataclass(frozen=True)
class MultiInnovation(Setting):
    """Numbers of a multi-innovation recursion: window `length` in samples, `omega` of the sine for each equation.

    Without omega the innovations are taken as they are; as printed, one omega serves all.
    """

    length: int = 10
    omega: tuple[float, ...] = ()
    window: list = field(default_factory=list)
    """Rows (y, h) of the last length - 1 samples, which the next window still needs."""

    def run(self, rows, per_sample: int, theta, state, spread, path) -> None:
        """As `Setting.run`; windows reach back over the ends of blocks and records."""
        from . import _kernels_innovation as kernels

        y, h, _ = rows
        first = len(self.window[0]) if self.window else 0
        if first:
            y, h = np.concatenate([self.window[0], y]), np.concatenate([self.window[1], h])
        if self.as_printed:
            kernels.multi_innovation_as_printed(y, h, first, per_sample, self.length, self.omega[0], theta, state, path)
        else:
            omega = np.array(self.omega, float)
            if omega.size not in (0, per_sample):  # an equation without unknowns has dropped out
                omega = np.full(per_sample, omega.max())
            kernels.multi_innovation(y, h, first, per_sample, self.length, omega, theta, state, spread, path)
        kept = min((self.length - 1) * per_sample, len(y))
        self.window[:] = [y[len(y) - kept :].copy(), h[len(y) - kept :].copy()]

    def times(self) -> float:
        """Every row is in `length` windows."""
        return float(self.length)


class MiRls(Rls):
    """Multi-innovation recursive least squares.

    Parameters
    ----------
    length : samples l in the window.  Every row is taken l times, so this is rls with an initial P l times as large:
        a weaker prior and nothing else.
    p0, theta0, prior, scheme : as in `rls`.
    """

    name = "mi-rls"
    title = "multi-innovation recursive least squares (paper 004)"
    search_space: ClassVar = {"length": Integer(1, 50, log=True), "p0": Real(1e-2, 1e12, log=True)}

    def __init__(
        self, length: int = 10, p0: float = 1e10, theta0=0.0, prior: str = "scaled", scheme: str = "forward"
    ) -> None:
        super().__init__(p0, theta0, prior, scheme)
        self.length = length

    def check_options(self) -> None:
        super().check_options()
        if not (self.length >= 1 and int(self.length) == self.length):
            raise BadInput(f"length is {self.length!r}, a whole number from 1 on is needed")

    def setting(self, p: int) -> Setting:
        return MultiInnovation(self.p0, self._theta0(p), prior=self.prior, length=int(self.length))
