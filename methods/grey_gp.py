"""A physical model with learnt residual accelerations: Gaussian processes."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, ClassVar

from ..estimation.methods_only.tuning.space import Integer
from .grey_residual import SHARE, Hybrid

if TYPE_CHECKING:
    from ..estimation.estimates.estimate import Estimate


class GreyGp(Hybrid):
    """A physical model, identified, plus a Gaussian process of its residual accelerations.

    As `grey-residual`, with g the mean of a Gaussian process with a squared-exponential kernel and white noise, on at
    most 300 rows.  Far from the training records g is zero, and the physics remains.  Source: Kennedy & O'Hagan 2001,
    J. R. Stat. Soc. B 63(3), 425 (the discrepancy of a calibrated model as a Gaussian process).

    Parameters
    ----------
    physics : method that identifies the coefficients, such as 'output-error' or 'pem'.
    stride : step of the innovations in samples; share : of g.  None: chosen by free runs.
    trials : option values tried; None: 4.
    seed : of the search.
    """

    name = "grey-gp"
    title = "physical model with a Gaussian process of residual accelerations"
    rows = 300
    usual_trials = 4
    search_space: ClassVar = {"stride": Integer(2, 16, log=True), "share": SHARE}
    usual: ClassVar = {"stride": 4, "share": 0.0}

    def __init__(
        self,
        physics: str | Estimate = "output-error",
        stride: int | None = None,
        share: float | None = None,
        trials: int | None = None,
        seed: int = 0,
    ) -> None:
        self.physics, self.stride, self.share, self.trials, self.seed = physics, stride, share, trials, seed

    def regressor(self, n_features: int) -> Any:
        from ..estimation.methods_only.black_box.gaussian_process import gaussian_process

        return gaussian_process(n_features)
