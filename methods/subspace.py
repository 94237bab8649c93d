"""Linear state-space models by subspace identification."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, ClassVar

from ..estimation.methods_only.black_box.state_space import training_of
from ..estimation.methods_only.black_box.subspace import identify
from ..estimation.methods_only.tuning.space import Integer
from .learner import STRIDE, Learner, black_box_fit

if TYPE_CHECKING:
    from ..datasets.record import Record
    from ..estimation.results.fit import Fit
    from ..models.model import Model


class Subspace(Learner):
    """Linear state-space model of velocities and yaw rate by a subspace method (PO-MOESP).

        x(t + h) = A x(t) + B w(t) + c,    z(t + h) = C x(t) + D w(t) + d

    The subspace of the states is what the past explains of the future outputs beyond the future inputs; B and D follow
    by least squares on free runs (`helmbench.estimation.methods_only.black_box.subspace`).  Eigenvalues of A outside
    the unit circle are reflected into it.  Sources: Verhaegen 1994, Automatica 30(1), 61; Ljung 1999, System
    Identification, section 10.6.  The order is chosen by free runs, not by a gap of singular values.

    Parameters
    ----------
    stride : h in samples; order : number of states x.  None: chosen by free runs.
    trials : option values tried; None: 12.
    seed : of the search.
    """

    name = "subspace"
    title = "linear state space by a subspace method (MOESP)"
    search_space: ClassVar = {"stride": STRIDE, "order": Integer(1, 8)}
    usual: ClassVar = {"stride": 4, "order": 2}

    def __init__(
        self, stride: int | None = None, order: int | None = None, trials: int | None = None, seed: int = 0
    ) -> None:
        self.stride, self.order, self.trials, self.seed = stride, order, trials, seed

    def learn(self, records: Sequence[Record], model: Model) -> Fit:
        training = training_of(records, model, int(self.stride or 1))
        system, lags = identify(training, int(self.order or 1))
        return black_box_fit(training.predictor(system, lags), rows=sum(len(part.whole) for part in training.parts))
