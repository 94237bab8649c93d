"""Diagnoser `nothing`: the base model is right."""

from __future__ import annotations

import time
from collections.abc import Sequence
from typing import TYPE_CHECKING

from ..prepared import prepared
from ..registry import Diagnoser
from .conclusion import conclude
from .output_error import FreeRuns

if TYPE_CHECKING:
    from ...datasets.record import Record
    from ...models.model import Model
    from ..options import Options
    from ..result import Diagnosis


class Nothing(Diagnoser):
    """Always says that nothing is wrong: what the others are compared with where most records are clean."""

    name = "nothing"
    title = "naive: nothing is wrong, whatever the records say"

    def diagnose(
        self, model: Model, train: Sequence[Record], held_out: Sequence[Record], options: Options
    ) -> Diagnosis:
        """Name nothing."""
        clock = time.perf_counter(), time.process_time()
        options = options.checked(model)
        train, held_out = prepared(train, model, options), prepared(held_out, model, options)
        return conclude(FreeRuns(model, train), held_out, [], "adequate", "nothing was looked for", options, clock)
