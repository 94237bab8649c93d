"""NMI-RLS: multi-innovation recursive least squares with sine-shaped innovations (paper 004), corrected and printed."""

from __future__ import annotations

from collections.abc import Sequence
from typing import ClassVar

import numpy as np

from ..models.errors import BadInput
from .mi_rls import MiRls, MultiInnovation
from .regression import Differences
from .rls import Setting
from .tuning.space import Integer, Real


class NmiRls(MiRls):
    """Nonlinear multi-innovation recursive least squares.

    Parameters
    ----------
    omega : in z = sin(omega e)/omega, omega e held within +-pi/2, where e is the error of the state predicted one
        sample ahead, in units of the state's root mean square.  Large innovations lose weight; towards 0 it is
        `mi-rls`, and at 1 nearly so.
    length, p0, theta0, prior, scheme : as in `mi-rls`.
    variant : 'corrected', or 'as_printed': z = sin(omega e) of innovations in units of the left side's root mean
        square, and eq 23 with the plus sign that makes P grow; it diverges.
    """

    name = "nmi-rls"
    title = "nonlinear multi-innovation recursive least squares (paper 004)"
    variants = ("corrected", "as_printed")
    search_space: ClassVar = {"omega": Real(0.03, 10.0, log=True), "length": Integer(1, 50, log=True)}

    def __init__(
        self,
        omega: float = 1.0,
        length: int = 10,
        p0: float = 1e6,
        theta0=0.0,
        prior: str = "scaled",
        scheme: str = "forward",
        variant: str = "corrected",
    ) -> None:
        super().__init__(length, p0, theta0, prior, scheme)
        self.omega, self.variant = omega, variant

    def check_options(self) -> None:
        super().check_options()
        if not self.omega > 0.0:
            raise BadInput(f"omega is {self.omega!r}, a positive number is needed (0 would be mi-rls)")

    def setting_for(self, parts: Sequence[Differences], p: int) -> Setting:
        printed = self.variant == "as_printed"
        omega = (self.omega,) if printed else tuple(self.omega * one_step_share(parts))
        return MultiInnovation(
            self.p0, self._theta0(p), prior=self.prior, as_printed=printed, length=int(self.length), omega=omega
        )


def one_step_share(parts: Sequence[Differences]) -> np.ndarray:
    """Root mean square (k,) of the change over one sample of each differentiated state, over that of the state."""
    k = parts[0].accelerations.shape[1]
    change, size = np.zeros(k), np.zeros(k)
    for part in parts:
        if len(part.time_s) > 1:
            dt = float(np.median(np.diff(part.time_s)))
            change += ((part.accelerations * dt) ** 2).sum(axis=0)
            size += (part.states[:, :k] ** 2).sum(axis=0)
    return np.sqrt(np.maximum(change, 1e-300) / np.maximum(size, 1e-300))
