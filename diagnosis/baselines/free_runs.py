"""Diagnoser `free-runs`: one bank of causes, numbers and terms, by free runs of pieces that were left out."""

from __future__ import annotations

import time
from dataclasses import replace
from typing import TYPE_CHECKING

from ..registry import Diagnoser

if TYPE_CHECKING:
    from collections.abc import Sequence

    from ...datasets.record import Record
    from ...models.model import Model
    from ..options import Options
    from ..result import Diagnosis


class FreeRunsOfPieces(Diagnoser):
    """`one_bank.diagnose.by_pieces` alone: the smallest set of the bank that predicts left-out pieces."""

    name = "free-runs"
    title = "one bank of causes, numbers and terms; free runs of left-out pieces; the smallest set"

    def diagnose(
        self, model: Model, train: Sequence[Record], held_out: Sequence[Record], options: Options
    ) -> Diagnosis:
        """See `helmbench.diagnosis.one_bank.diagnose.by_pieces`."""
        from ...estimation.results.fit import arithmetic_guard, blas_limited
        from ..checked import with_checks
        from ..diagnose import identified
        from ..one_bank.diagnose import by_pieces
        from ..prepared import corrected_records

        clock = time.perf_counter(), time.process_time()
        options = options.checked(model)
        with arithmetic_guard(), blas_limited():
            given = corrected_records(model, train, held_out, options)
            if options.base_parameters == "identify":
                model = identified(model, given.train)
            said = by_pieces(model, given, held_out, options).diagnosis
        said = with_checks(said, given.checked, (*given.train, *given.held_out))
        roles = [(r.name, "train") for r in train] + [(r.name, "held_out") for r in held_out]
        wall_s, cpu_s = time.perf_counter() - clock[0], time.process_time() - clock[1]
        return replace(said, records=tuple(roles), wall_s=wall_s, cpu_s=cpu_s)
