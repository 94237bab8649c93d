"""Sparse regression on the terms of manoeuvring models (SINDy)."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, ClassVar

from ..estimation.methods_only.tuning.space import Real
from .learner import STRIDE, NarxLearner

if TYPE_CHECKING:
    from ..models.model import Model


class Sindy(NarxLearner):
    """Sparse identification of nonlinear dynamics with the terms of manoeuvring models.

    Accelerations are sums of few of these terms: all monomials up to degree three of the velocities, yaw rate and
    rudder, and products such as |v| v, |v| r and |r| r.  Coefficients below `threshold` are removed and the others
    fitted again until none is.  Source: Brunton, Proctor & Kutz 2016, PNAS 113(15), 3932.  The regression is the
    package's own, which a test compares with that of pysindy; threshold and penalty are chosen by free runs.

    Parameters
    ----------
    stride : step of the accelerations in samples; threshold : of a term of unit size, relative to the acceleration's
        spread; alpha : ridge penalty.  None: chosen by free runs.
    trials : option values tried; None: 12.
    seed : of the search.
    """

    name = "sindy"
    title = "sparse regression on terms of manoeuvring models (SINDy)"
    search_space: ClassVar = {
        "stride": STRIDE,
        "threshold": Real(1e-3, 0.5, log=True),
        "alpha": Real(1e-9, 1e-2, log=True),
    }
    usual: ClassVar = {"stride": 4, "threshold": 0.05, "alpha": 1e-5}

    def __init__(
        self,
        stride: int | None = None,
        threshold: float | None = None,
        alpha: float | None = None,
        trials: int | None = None,
        seed: int = 0,
    ) -> None:
        self.stride, self.threshold, self.alpha, self.trials, self.seed = stride, threshold, alpha, trials, seed

    def regressor(self, model: Model, symbols: tuple[str, ...]) -> Any:
        from ..estimation.methods_only.black_box.rows import SYMMETRIC
        from ..estimation.methods_only.black_box.terms import TermRegression, manoeuvring_terms

        factors = manoeuvring_terms([symbol in SYMMETRIC for symbol in symbols])
        return TermRegression(factors, alpha=self.alpha or 0.0, threshold=self.threshold or 0.0)
