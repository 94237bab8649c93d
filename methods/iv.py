"""Instrumental variables: lagged regressors, then regressors simulated with the estimate itself, iterated."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, ClassVar

from ..estimation.methods_only.regression.instrumental import lagged_fit, refined_fit
from ..estimation.methods_only.tuning.space import Choice, Integer
from ..estimation.regression.schemes import check_scheme
from ..estimation.results.fit import Fit
from ..models.errors import BadInput
from .base import Method

if TYPE_CHECKING:
    from ..datasets.record import Record
    from ..models.model import Model

INSTRUMENTS = ("simulated", "lagged")


class Iv(Method):
    """Instrumental-variable estimate, iterated as in refined IV (SRIVC).

    Noise on the channels is in the regressors too and biases least squares.  Instruments are regressors without that
    noise: those of a run simulated with the last estimate from the record's inputs ('simulated'), or those of the
    record some samples earlier ('lagged'), which also start the iteration.

    Parameters
    ----------
    instruments : 'simulated' or 'lagged'.
    lag : samples by which lagged instruments are late.
    iterations : most simulations; the iteration ends when no coefficient changes by a hundredth of its standard error.
    horizon_s : the simulation is restarted from the record after so many seconds, and whenever it is far from the
        record; None simulates the whole record as long as it stays near.
    scheme : difference scheme, see `helmbench.estimation.regression.schemes`; the default integrates, so that the
        equation's noise stays white.

    Equations are weighted by their residuals.  Standard errors allow for noise that is correlated over a few samples
    (Newey & West 1987).  Young & Jakeman 1979; Garnier & Young 2008 for SRIVC.
    """

    name = "iv"
    title = "instrumental variables, lagged and simulated, iterated"
    search_space: ClassVar = {"instruments": Choice("simulated", "lagged"), "lag": Integer(1, 40, log=True)}

    def __init__(
        self,
        instruments: str = "simulated",
        lag: int = 4,
        iterations: int = 12,
        horizon_s: float | None = None,
        scheme: str = "triple-integral",
    ) -> None:
        self.instruments, self.lag, self.iterations = instruments, lag, iterations
        self.horizon_s, self.scheme = horizon_s, scheme

    def check_options(self) -> None:
        super().check_options()
        check_scheme(self.scheme)
        if self.instruments not in INSTRUMENTS:
            raise BadInput(f"instruments is {self.instruments!r}", hint=f"known: {', '.join(INSTRUMENTS)}")
        if not (self.lag >= 1 and self.iterations >= 1):
            raise BadInput("lag and iterations are numbers from 1 on")
        if self.horizon_s is not None and not self.horizon_s > 0.0:
            raise BadInput(f"horizon_s is {self.horizon_s!r}, a positive number is needed")

    def estimate(self, records: Sequence[Record], model: Model) -> Fit:
        found, count, converged = lagged_fit(records, model, self.scheme, self.lag), 0, True
        if self.instruments == "simulated":
            found, count, converged = refined_fit(records, model, self.scheme, found, self.iterations, self.horizon_s)
        return Fit(
            found.coefficients,
            found.covariance,
            converged,
            "" if converged else f"not converged after {count} simulations",
            count + 1,
            extra={"residual_sd": found.residual_sd.tolist(), "rank": found.rank},
        )
