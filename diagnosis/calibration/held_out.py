"""Free runs of a calibration's models along held-out records: the same runs and errors as of every command."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import TYPE_CHECKING, NamedTuple

from ...estimation.run.run import run_along, squares_of
from ...estimation.run.stretch import Stretch
from ..gain.runs import trace_of

if TYPE_CHECKING:
    from ...datasets.record import Record
    from ...estimation.run.run import Run
    from ...estimation.run.stretch import FreeRun
    from ...models.model import Model
    from ..trace import Trace

Errors = Mapping[str, tuple[float, float | None]]
"""Column -> errors of left-out training records and of held-out records, SI."""


class HeldOut(NamedTuple):
    """Held-out records as they were read, and with the current and wind that known causes add to what they measure."""

    recorded: Sequence[Record]
    explained: Sequence[Record]

    def base_runs(self, model: Model, by: Callable[[Stretch], FreeRun] = Stretch.free_run) -> list[Run]:
        """Runs of the base model along the records as they were read; by as `run_along` has it."""
        return [run_along(model, record, by=by) for record in self.recorded]

    def runs(self, model: Model, by: Callable[[Stretch], FreeRun] = Stretch.free_run) -> list[Run]:
        """Runs of a model whose numbers moved, with the instruments that were found."""
        return [run_along(model, record, by=by) for record in self.explained]

    def traces(self, base: Model, moved: Model) -> tuple[Trace, ...]:
        """Measured channels against both, as the record's own sensors show them."""
        pairs = zip(self.base_runs(base), self.runs(moved), strict=True)
        return tuple(trace_of(before, after, "held_out") for before, after in pairs)


def with_held_out(errors: Errors, runs: Sequence[Run]) -> Errors:
    """Errors with those of the runs in the place of held-out ones, in the columns that the runs have."""
    found = {column: sums.scores()[0] for column, sums in squares_of(runs).items()}
    return {column: (own, found.get(column, held)) for column, (own, held) in errors.items()}
