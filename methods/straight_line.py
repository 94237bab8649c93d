"""Straight on at the speed of the start."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from ..estimation.methods_only.black_box.constant import ConstantPredictor
from ..estimation.methods_only.black_box.rows import outputs_of, signals_of
from .base import Method
from .learner import black_box_fit

if TYPE_CHECKING:
    from ..datasets.record import Record
    from ..estimation.results.fit import Fit
    from ..models.model import Model


class StraightLine(Method):
    """The ship keeps the surge and sway speed of its start and does not turn: its yaw rate is zero.

    One sample ahead, the speeds are those of the sample before.  Nothing is learnt from the training records.
    """

    name = "straight-line"
    title = "straight on at the initial speed, without turning"
    kind = "floor"

    def estimate(self, records: Sequence[Record], model: Model) -> Fit:
        signals_of(records, model)  # records that no method can use are refused
        outputs = outputs_of(model)
        values = tuple(0.0 if name == "r" else np.nan for name in outputs)
        return black_box_fit(ConstantPredictor(tuple(model.states), outputs, values))
