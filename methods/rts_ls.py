"""Least squares on smoothed states and accelerations."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, ClassVar

import numpy as np

from ..estimation.methods_only.regression.smoothed import smoothed_rows
from ..estimation.methods_only.tuning.space import Real
from ..estimation.numerics import factors
from ..estimation.observers.smoothing import averaging_length
from ..estimation.regression.filtered import row_factors
from ..estimation.regression.filtered_fit import FilteredFit, coloured_covariance
from ..estimation.regression.least_squares import least_squares
from ..estimation.results.fit import Fit
from ..models.errors import BadInput
from .base import Method

if TYPE_CHECKING:
    from ..datasets.record import Record
    from ..models.model import Model


class RtsLs(Method):
    """Records smoothed by a kinematic model, then least squares on the states and accelerations.

    Surge, sway and yaw are each an integrated random walk, whose order and process noise have the largest likelihood
    for all records; heading and yaw rate are smoothed as one motion.  The smoother (Rauch-Tung-Striebel) has no lag,
    but it rounds off fast changes; the rudder passes through yaw's smoother too, so a linear equation of yaw stays
    exact.

    Parameters
    ----------
    level : factor on the process noise: below 1 smooths more than the likelihood suggests.

    3-DOF models need surge, sway and yaw rate or heading, response models yaw rate or heading.
    """

    name = "rts-ls"
    title = "least squares on states and accelerations smoothed by a kinematic model (RTS)"
    search_space: ClassVar = {"level": Real(1e-3, 1e3, log=True)}

    def __init__(self, level: float = 1.0) -> None:
        self.level = level

    def check_options(self) -> None:
        super().check_options()
        if not self.level > 0.0:
            raise BadInput(f"level is {self.level!r}, a positive number is needed")

    def estimate(self, records: Sequence[Record], model: Model) -> Fit:
        rows, walks, dt = smoothed_rows(records, model, self.level)
        found = least_squares(*row_factors(rows, model))
        slowest = max(averaging_length(walk) for walk in walks.values()) * dt
        return Fit(
            found.coefficients,
            coloured_covariance(FilteredFit(1.0 / slowest, rows, found, np.nan), model),
            message=factors.rank_message(found.rank, len(model.coordinates)),
            extra={"rank": found.rank, "walks": {s: {"order": w.order, "level": w.level} for s, w in walks.items()}},
        )
