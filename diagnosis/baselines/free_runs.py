"""Diagnoser `free-runs`: one bank of causes, numbers and terms, by free runs of pieces that were left out."""

from __future__ import annotations

from typing import TYPE_CHECKING

from ..registry import Diagnoser

if TYPE_CHECKING:
    from collections.abc import Sequence

    from ...datasets.record import Record
    from ...models.model import Model
    from ..options import Options
    from ..result import Diagnosis


class FreeRunsOfPieces(Diagnoser):
    """`one_bank.diagnose`: the smallest set of the bank that predicts left-out pieces of the records."""

    name = "free-runs"
    title = "one bank of causes, numbers and terms; free runs of left-out pieces; the smallest set"

    def diagnose(
        self, model: Model, train: Sequence[Record], held_out: Sequence[Record], options: Options
    ) -> Diagnosis:
        """See `helmbench.diagnosis.one_bank.diagnose.diagnose`."""
        from ..one_bank.diagnose import diagnose

        return diagnose(model, train, held_out, options)
