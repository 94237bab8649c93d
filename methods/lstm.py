"""A long short-term memory network."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, ClassVar

from ..estimation.black_box.state_space import training_of
from ..estimation.tuning.space import Integer, Real
from .learner import Learner, black_box_fit

if TYPE_CHECKING:
    from ..datasets.record import Record
    from ..estimation.fit import Fit
    from ..models.model import Model


class Lstm(Learner):
    """Long short-term memory network of outputs and inputs, trained on free runs of windows.

        z(t + h) = z(t) + V (m, 1),    m: hidden state of an LSTM layer that takes z and w of every step

    A run begins with a memory of zeros some steps before its first sample and takes the measured outputs up to there.
    Training is Adam on mini batches with a decay of the weights, for a fixed number of updates, without early stopping.
    Gradients through the recursion are jax's, so the method needs the extra `deep` and does not apply without it
    (`helmbench.estimation.black_box.lstm`).  Sources: Hochreiter & Schmidhuber 1997, Neural Comput. 9(8), 1735; for
    ships Woo, Park, Yu & Kim 2018, Appl. Ocean Res. 73.

    Parameters
    ----------
    stride : h in samples; decay : of the weights, relative to the step size.  None: chosen by free runs.
    units : hidden states, and as many cell states; iterations : updates of the weights, half as many in a trial.
    trials : option values tried; None: 6.
    seed : of the first weights, the batches and the search.
    """

    name = "lstm"
    title = "long short-term memory network (LSTM), trained on free runs"
    minutes = True
    brief: ClassVar = {"units": 8, "iterations": 100}
    usual_trials = 6
    search_space: ClassVar = {"stride": Integer(1, 8, log=True), "decay": Real(0.1, 1.0, log=True)}
    usual: ClassVar = {"stride": 2, "decay": 0.4}

    def __init__(
        self,
        stride: int | None = None,
        decay: float | None = None,
        units: int = 32,
        iterations: int = 2000,
        trials: int | None = None,
        seed: int = 0,
    ) -> None:
        self.stride, self.decay, self.units, self.iterations = stride, decay, units, iterations
        self.trials, self.seed = trials, seed

    def check_options(self) -> None:
        super().check_options()
        self.require_whole("units", 1)
        self.require_whole("iterations", 1)

    def estimate(self, records: Sequence[Record], model: Model) -> Fit:
        from ..estimation.black_box.free_runs import require_jax

        require_jax()
        return super().estimate(records, model)

    def for_search(self, records: Sequence[Record], model: Model) -> Learner:
        return self._with({"iterations": -(-self.iterations // 2)})

    def learn(self, records: Sequence[Record], model: Model) -> Fit:
        from ..estimation.black_box.lstm import LAGS, train

        training = training_of(records, model, int(self.stride or 1))
        network = train(training, self.units, self.iterations, self.decay or 0.0, self.seed)
        fit = black_box_fit(training.predictor(network, LAGS), rows=sum(len(part.whole) for part in training.parts))
        return fit._replace(n_iterations=self.iterations)
