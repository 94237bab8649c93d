"""Batch least squares on difference equations (papers 000, 001 and 002 in their corrected form)."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, ClassVar

from ..estimation.methods_only.regression.replay import replayed_covariance
from ..estimation.methods_only.regression.zero_order_hold import common_step, exact_with_covariance
from ..estimation.methods_only.tuning.space import Choice
from ..estimation.numerics import factors
from ..estimation.regression.least_squares import fit_by_scheme
from ..estimation.regression.schemes import INTEGRATED, check_scheme
from ..estimation.results.fit import Fit
from .base import Method

if TYPE_CHECKING:
    from ..datasets.record import Record
    from ..models.model import Model


class Ls(Method):
    """Least squares on the model's difference equations, solved by orthogonal decomposition.

    Parameters
    ----------
    scheme : a scheme of `helmbench.estimation.regression.schemes` ('forward' is explicit Euler), or
        'zoh': forward differences converted by the exact map for a held rudder
        (`helmbench.estimation.methods_only.regression.zero_order_hold`), for response models.

    3-DOF models need surge, sway and yaw rate (or heading); response models yaw rate or heading.  Standard errors take
    the equations' errors as independent, except for the integrated schemes, where sensor noise is coloured
    (`helmbench.estimation.methods_only.regression.replay`).
    """

    name = "ls"
    title = "batch least squares on difference equations (QR)"
    search_space: ClassVar = {"scheme": Choice("forward", "midpoint")}

    def __init__(self, scheme: str = "forward") -> None:
        self.scheme = scheme

    def check_options(self) -> None:
        super().check_options()
        check_scheme(self.scheme, ("zoh",))

    def estimate(self, records: Sequence[Record], model: Model) -> Fit:
        scheme = "forward" if self.scheme == "zoh" else self.scheme
        found = fit_by_scheme(records, model, scheme)
        coefficients, covariance, p = found.coefficients, found.covariance, len(model.coordinates)
        if scheme in INTEGRATED and found.rank == p:
            covariance = replayed_covariance(records, lambda r: fit_by_scheme(r, model, scheme).coefficients)
        if self.scheme == "zoh":
            coefficients, covariance = exact_with_covariance(coefficients, covariance, model, common_step(records))
        return Fit(
            coefficients,
            covariance,
            message=factors.rank_message(found.rank, p),
            extra={"rank": found.rank, "condition": found.condition, "residual_sd": found.residual_sd.tolist()},
        )
