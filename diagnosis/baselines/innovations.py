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
    """`diagnose`: innovations with an estimated noise model, score tests over the bank, forward selection."""

    name = "innovations"
    title = "innovations with coloured forces, projected score tests over the bank, refits, ties"

    def diagnose(
        self, model: Model, train: Sequence[Record], held_out: Sequence[Record], options: Options
    ) -> Diagnosis:
        """See `helmbench.diagnosis.diagnose.diagnose`."""
        from ..diagnose import diagnose

        return diagnose(model, train, held_out, options)
