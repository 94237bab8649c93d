"""Diagnoser `innovations`: the project's own diagnosis."""

from __future__ import annotations

from typing import TYPE_CHECKING

from ..registry import Diagnoser

if TYPE_CHECKING:
    from collections.abc import Sequence

    from ...datasets.record import Record
    from ...models.model import Model
    from ..options import Options
    from ..result import Diagnosis


class Innovations(Diagnoser):
    """`diagnose`: free runs of left-out pieces over one bank; of an exact base model innovations and score tests."""

    name = "innovations"
    title = "free runs of left-out pieces over one bank; of an exact base model innovations with coloured forces"

    def diagnose(
        self, model: Model, train: Sequence[Record], held_out: Sequence[Record], options: Options
    ) -> Diagnosis:
        """See `helmbench.diagnosis.diagnose.diagnose`."""
        from ..diagnose import diagnose

        return diagnose(model, train, held_out, options)
