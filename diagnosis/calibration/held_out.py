"""Free runs of a calibration's models along held-out records: the same runs and errors as of every command."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from ...estimation.run.run import run_along, squares_of
from ...estimation.run.stretch import Stretch
from ..trace import Trace

if TYPE_CHECKING:
    from ...datasets.record import Record
    from ...estimation.run.run import Run
    from ...estimation.run.stretch import FreeRun
    from ...models.model import Model

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
        return tuple(map(_trace, self.base_runs(base), self.runs(moved)))


def with_held_out(errors: Errors, runs: Sequence[Run]) -> Errors:
    """Errors with those of the runs in the place of held-out ones, in the columns that the runs have."""
    found = {column: sums.scores()[0] for column, sums in squares_of(runs).items()}
    return {column: (own, found.get(column, held)) for column, (own, held) in errors.items()}


def _trace(before: Run, after: Run) -> Trace:
    own, other = before.measured, after.measured
    names = [c for c in before.predicted if c in after.predicted]
    measured = {c: own.channels[c] for c in names}
    errors = {c: other.channels[c] - after.predicted[c] for c in names}
    if other.time_s.size != own.time_s.size:
        errors = {c: np.interp(own.time_s, other.time_s, error) for c, error in errors.items()}
    shown = {c: measured[c] - errors[c] for c in names}
    return Trace(own.name, "held_out", own.time_s - own.time_s[0], own.rudder, measured,
                 {c: before.predicted[c] for c in names}, shown)  # fmt: skip
