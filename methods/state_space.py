"""State-space models learnt from free runs: linear, lifted, and recurrent networks."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, ClassVar

from ..datasets.record import Record
from ..estimation.methods_only.black_box.state_space import Training, training_of
from ..estimation.methods_only.black_box.subspace import identify
from ..estimation.methods_only.tuning.space import Integer, Real
from ..estimation.results.fit import Fit
from ..models.model import Model
from .base import Method
from .learner import LAGS, STRIDE, Learner, black_box_fit, in_order, open_option
from .options import NOT_NEGATIVE, option, whole


def _fit(training: Training, system: Any, lags: int) -> Fit:
    return black_box_fit(training.predictor(system, lags), rows=sum(len(part.whole) for part in training.parts))


class Subspace(Learner):
    """Linear state-space model of velocities and yaw rate by a subspace method (PO-MOESP).

        x(t + h) = A x(t) + B w(t) + c,    z(t + h) = C x(t) + D w(t) + d

    The subspace of the states is what the past explains of the future outputs beyond the future inputs; B and D follow
    by least squares on free runs (`helmbench.estimation.methods_only.black_box.subspace`).  Eigenvalues of A outside
    the unit circle are reflected into it.  Sources: Verhaegen 1994, Automatica 30(1), 61; Ljung 1999, System
    Identification, section 10.6.  The order is chosen by free runs, not by a gap of singular values.
    """

    name = "subspace"
    title = "linear state space by a subspace method (MOESP)"
    stride: int | None = STRIDE
    order: int | None = open_option("number of states x", Integer(1, 8), 2)

    def learn(self, records: Sequence[Record], model: Model) -> Fit:
        training = training_of(records, model, int(self.stride or 1))
        return _fit(training, *identify(training, int(self.order or 1)))


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
    """

    name = "edmd"
    title = "linear model of lifted outputs (EDMD with control, Koopman)"
    stride: int | None = STRIDE
    degree: int | None = open_option("of the products, 1, 2 or 3", Integer(1, 3), 1)
    output_lags: int | None = open_option("values of the outputs that are lifted", LAGS, 1)
    alpha: float | None = open_option("ridge penalty", Real(1e-9, 1e-1, log=True), 1e-6)
    bilinear: bool = option(True, "whether products of inputs and lifted outputs act too")

    def learn(self, records: Sequence[Record], model: Model) -> Fit:
        from ..estimation.methods_only.black_box.koopman import lift

        training, lags = training_of(records, model, int(self.stride or 1)), int(self.output_lags or 1)
        system = lift(training, int(self.degree or 1), lags, self.alpha or 0.0, self.bilinear)
        return _fit(training, system, lags)


class Recurrent(Learner):
    """Recurrent network: a neural state-space model with hidden states, trained on free runs of windows.

        s(t + h) = s(t) + A (s, w, 1) + V tanh(U (s, w, 1)),    s = (z, hidden states)

    Hidden states begin as a linear function of past samples.  Gradients through the recursion are jax's, so the method
    needs the extra `deep` and does not apply without it (`helmbench.estimation.methods_only.black_box.recurrent`).
    Sources: Suykens, De Moor & Vandewalle 1995, Int. J. Control 62(1), 129; Beintema, Toth & Schoukens 2021, PMLR 144,
    1021.
    """

    name = "recurrent"
    title = "recurrent neural network (neural state space), trained on free runs"
    usual_trials = 4
    stride: int | None = STRIDE
    alpha: float | None = open_option("penalty on the weights", Real(1e-7, 1e-3, log=True), 1e-5)
    units: int = option(8, "tanh units", whole(1))
    hidden: int = option(2, "hidden states", whole(0))

    def estimate(self, records: Sequence[Record], model: Model) -> Fit:
        from ..estimation.methods_only.black_box.free_runs import require_jax

        require_jax()
        return super().estimate(records, model)

    def learn(self, records: Sequence[Record], model: Model) -> Fit:
        from ..estimation.methods_only.black_box.recurrent import LAGS, train

        training = training_of(records, model, int(self.stride or 1))
        return _fit(training, train(training, self.hidden, self.units, self.alpha or 0.0, self.seed), LAGS)


class Lstm(Method):
    """Long short-term memory network of outputs and inputs, trained on free runs of windows.

        z(t + h) = z(t) + V (m, 1),    m: hidden state of an LSTM layer that takes z and w of every step

    A run begins with a memory of zeros some steps before its first sample and takes the measured outputs up to there.
    Training is Adam on mini batches with a decay of the weights, for a fixed number of updates.  There is neither early
    stopping nor a choice of options within the fit: on five simulated ships, both judged by the later part of the same
    training records, neither predicted other manoeuvres better, and the choice twice much worse.  Gradients through the
    recursion are jax's, so the method needs the extra `deep` and does not apply without it
    (`helmbench.estimation.methods_only.black_box.lstm`).  Sources: Hochreiter & Schmidhuber 1997, Neural Comput. 9(8),
    1735; for ships Woo, Park, Yu & Kim 2018, Appl. Ocean Res. 73.
    """

    name = "lstm"
    title = "long short-term memory network (LSTM), trained on free runs"
    kind = "black box"
    minutes = True
    brief: ClassVar = {"units": 8, "iterations": 100}
    stride: int = option(2, "h in samples", whole(1), Integer(1, 8, log=True))
    decay: float = option(
        0.4, "of the weights at each update, relative to the step size", NOT_NEGATIVE, Real(0.1, 1.0, log=True)
    )
    units: int = option(32, "hidden states, and as many cell states", whole(1))
    iterations: int = option(2000, "updates of the weights", whole(1))
    seed: int = option(0, "of the first weights and the batches", whole(0))

    def estimate(self, records: Sequence[Record], model: Model) -> Fit:
        from ..estimation.methods_only.black_box.lstm import LAGS, train

        training = training_of(in_order(records), model, self.stride)
        network = train(training, self.units, self.iterations, self.decay, self.seed)
        return _fit(training, network, LAGS)._replace(n_iterations=self.iterations)
