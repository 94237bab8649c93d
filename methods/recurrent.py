"""A small recurrent neural network."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, ClassVar

from ..estimation.methods_only.black_box.state_space import training_of
from ..estimation.methods_only.tuning.space import Real
from ..models.errors import BadInput
from .learner import STRIDE, Learner, black_box_fit

if TYPE_CHECKING:
    from ..datasets.record import Record
    from ..estimation.results.fit import Fit
    from ..models.model import Model


class Recurrent(Learner):
    """Recurrent network: a neural state-space model with hidden states, trained on free runs of windows.

        s(t + h) = s(t) + A (s, w, 1) + V tanh(U (s, w, 1)),    s = (z, hidden states)

    Hidden states begin as a linear function of past samples.  Gradients through the recursion are jax's, so the method
    needs the extra `deep` and does not apply without it (`helmbench.estimation.methods_only.black_box.recurrent`).
    Sources: Suykens, De Moor & Vandewalle 1995, Int. J. Control 62(1), 129; Beintema, Toth & Schoukens 2021, PMLR 144,
    1021.

    Parameters
    ----------
    stride : h in samples; alpha : penalty on the weights.  None: chosen by free runs.
    units : tanh units; hidden : hidden states.
    trials : option values tried; None: 4.
    seed : of the first weights and the search.
    """

    name = "recurrent"
    title = "recurrent neural network (neural state space), trained on free runs"
    usual_trials = 4
    search_space: ClassVar = {"stride": STRIDE, "alpha": Real(1e-7, 1e-3, log=True)}
    usual: ClassVar = {"stride": 4, "alpha": 1e-5}

    def __init__(
        self,
        stride: int | None = None,
        alpha: float | None = None,
        units: int = 8,
        hidden: int = 2,
        trials: int | None = None,
        seed: int = 0,
    ) -> None:
        self.stride, self.alpha, self.units, self.hidden = stride, alpha, units, hidden
        self.trials, self.seed = trials, seed

    def check_options(self) -> None:
        super().check_options()
        if not (self.units >= 1 and self.hidden >= 0):
            raise BadInput(f"units is {self.units!r} and hidden {self.hidden!r}, at least 1 and 0 are needed")

    def estimate(self, records: Sequence[Record], model: Model) -> Fit:
        from ..estimation.methods_only.black_box.free_runs import require_jax

        require_jax()
        return super().estimate(records, model)

    def learn(self, records: Sequence[Record], model: Model) -> Fit:
        from ..estimation.methods_only.black_box.recurrent import LAGS, train

        training = training_of(records, model, int(self.stride or 1))
        network = train(training, self.hidden, self.units, self.alpha or 0.0, self.seed)
        return black_box_fit(training.predictor(network, LAGS), rows=sum(len(part.whole) for part in training.parts))
