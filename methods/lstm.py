"""A long short-term memory network."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, ClassVar

from ..estimation.methods_only.black_box.state_space import training_of
from ..estimation.methods_only.tuning.space import Integer, Real
from ..models.errors import BadInput
from .base import Method
from .learner import black_box_fit, in_order

if TYPE_CHECKING:
    from ..datasets.record import Record
    from ..estimation.results.fit import Fit
    from ..models.model import Model


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

    Parameters
    ----------
    stride : h in samples.
    decay : >= 0, of the weights at each update, relative to the step size.
    units : hidden states, and as many cell states; iterations : updates of the weights.
    seed : of the first weights and the batches.
    """

    name = "lstm"
    title = "long short-term memory network (LSTM), trained on free runs"
    kind = "black box"
    minutes = True
    brief: ClassVar = {"units": 8, "iterations": 100}
    search_space: ClassVar = {"stride": Integer(1, 8, log=True), "decay": Real(0.1, 1.0, log=True)}

    def __init__(
        self, stride: int = 2, decay: float = 0.4, units: int = 32, iterations: int = 2000, seed: int = 0
    ) -> None:
        self.stride, self.decay, self.units, self.iterations, self.seed = stride, decay, units, iterations, seed

    def check_options(self) -> None:
        super().check_options()
        for name in ("stride", "units", "iterations"):
            self.require_whole(name, 1)
        self.require_whole("seed", 0)
        if not self.decay >= 0.0:
            raise BadInput(f"decay is {self.decay!r}, a number >= 0 is needed")

    def estimate(self, records: Sequence[Record], model: Model) -> Fit:
        from ..estimation.methods_only.black_box.lstm import LAGS, train

        training = training_of(in_order(records), model, self.stride)
        network = train(training, self.units, self.iterations, self.decay, self.seed)
        fit = black_box_fit(training.predictor(network, LAGS), rows=sum(len(part.whole) for part in training.parts))
        return fit._replace(n_iterations=self.iterations)
