"""Instrumental variables: lagged regressors, then regressors simulated with the estimate itself, iterated."""

from __future__ import annotations

from collections.abc import Sequence

from ..datasets.record import Record
from ..estimation.methods_only.regression.instrumental import lagged_fit, refined_fit
from ..estimation.methods_only.tuning.space import Choice, Integer
from ..estimation.results.fit import Fit
from ..models.model import Model
from .base import DIFFERENCE, Method
from .options import POSITIVE, option, whole, words

INSTRUMENTS = ("simulated", "lagged")


class Iv(Method):
    """Instrumental-variable estimate, iterated as in refined IV (SRIVC).

    Noise on the channels is in the regressors too and biases least squares.  Instruments are regressors without that
    noise: those of a run simulated with the last estimate from the record's inputs ('simulated'), or those of the
    record some samples earlier ('lagged'), which also start the iteration.

    Equations are weighted by their residuals.  Standard errors allow for noise that is correlated over a few samples
    (Newey & West 1987).  Young & Jakeman 1979; Garnier & Young 2008 for SRIVC.
    """

    name = "iv"
    title = "instrumental variables, lagged and simulated, iterated"
    instruments: str = option(
        "simulated", "'simulated' or 'lagged'", words("instruments", INSTRUMENTS), Choice(*INSTRUMENTS)
    )
    lag: int = option(4, "samples by which lagged instruments are late", whole(1), Integer(1, 40, log=True))
    iterations: int = option(
        12,
        "most simulations; the iteration ends when no coefficient changes by a hundredth of its standard error",
        whole(1),
    )
    horizon_s: float | None = option(
        None,
        "the simulation is restarted from the record after so many seconds, and whenever it is far from the record; "
        "None simulates the whole record as long as it stays near",
        POSITIVE,
    )
    scheme: str = option(
        "triple-integral",
        "difference scheme, see `helmbench.estimation.regression.schemes`; the default integrates, so that the "
        "equation's noise stays white",
        DIFFERENCE,
    )

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
