"""Linear models of lifted outputs."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, ClassVar

from ..estimation.methods_only.black_box.state_space import training_of
from ..estimation.methods_only.tuning.space import Integer, Real
from .learner import LAGS, STRIDE, Learner, black_box_fit

if TYPE_CHECKING:
    from ..datasets.record import Record
    from ..estimation.results.fit import Fit
    from ..models.model import Model


class Edmd(Learner):
    """Extended dynamic mode decomposition with control (EDMDc), a finite approximation of the Koopman operator.

        g(z(t + h)) = A g(z(t)) + B w(t) + c

    g(z) are velocities, yaw rate and their products up to a degree, also of earlier steps; A, B and c follow by ridge
    regression (`helmbench.estimation.methods_only.black_box.koopman`).  A free run moves the lifted state on linearly
    and computes no product anew: this makes it a Koopman model, and `narx-poly` none.  With degree=1 it is dynamic mode
    decomposition with control (DMDc).  Inputs act linearly: what a rudder does in proportion to the state, such as the
    loss of speed in a turn, has no place in this form.  A is not made stable: options whose free runs diverge are not
    chosen.  Sources: Proctor, Brunton & Kutz 2016, SIAM J. Appl. Dyn. Syst. 15(1), 142; Williams, Kevrekidis & Rowley
    2015, J. Nonlinear Sci. 25, 1307; Korda & Mezic 2018, Automatica 93, 149.

    Parameters
    ----------
    stride : h in samples; degree : of the products, 1, 2 or 3; output_lags : values of the outputs that are lifted;
        alpha : ridge penalty.  None: chosen by free runs.
    bilinear : whether products of inputs and lifted outputs act too.
    trials : option values tried; None: 12.
    seed : of the search.
    """

    name = "edmd"
    title = "linear model of lifted outputs (EDMD with control, Koopman)"
    search_space: ClassVar = {
        "stride": STRIDE,
        "degree": Integer(1, 3),
        "output_lags": LAGS,
        "alpha": Real(1e-9, 1e-1, log=True),
    }
    usual: ClassVar = {"stride": 4, "degree": 1, "output_lags": 1, "alpha": 1e-6}

    def __init__(
        self,
        stride: int | None = None,
        degree: int | None = None,
        output_lags: int | None = None,
        alpha: float | None = None,
        bilinear: bool = True,
        trials: int | None = None,
        seed: int = 0,
    ) -> None:
        self.stride, self.degree, self.output_lags = stride, degree, output_lags
        self.alpha, self.bilinear, self.trials, self.seed = alpha, bilinear, trials, seed

    def learn(self, records: Sequence[Record], model: Model) -> Fit:
        from ..estimation.methods_only.black_box.koopman import lift

        training, lags = training_of(records, model, int(self.stride or 1)), int(self.output_lags or 1)
        system = lift(training, int(self.degree or 1), lags, self.alpha or 0.0, self.bilinear)
        return black_box_fit(training.predictor(system, lags), rows=sum(len(part.whole) for part in training.parts))
