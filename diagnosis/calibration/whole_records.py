"""Training and held-out records, whole: with a model whose numbers move, and the errors of its free runs, which are the
same as of every command.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from ...estimation.run.run import run_along, squares_of
from ...estimation.run.stretch import Stretch
from ...estimation.selection.selection import mean_squares
from ...models.time_scale import time_scale_s
from ..free_runs.bank import Place, of_numbers
from ..free_runs.problem import FreeRuns
from ..free_runs.units import units_of, whole_unit
from ..gain.runs import trace_of

if TYPE_CHECKING:
    from ...datasets.record import Record
    from ...estimation.run.run import Run
    from ...estimation.run.stretch import FreeRun
    from ...models.model import Model
    from ..prepared import Prepared
    from ..result import Trace


class WholeRecords(NamedTuple):
    """Free runs of training and held-out records."""

    train: FreeRuns
    held_out: FreeRuns | None

    def with_numbers(self, places: Mapping[str, Place]) -> WholeRecords:
        """The same with further numbers, and what these move."""
        held_out = None if self.held_out is None else self.held_out.with_numbers(places, {})
        return WholeRecords(self.train.with_numbers(places, {}), held_out)

    def with_inputs(self, change: Callable[[np.ndarray], np.ndarray]) -> WholeRecords:
        """The same with the inputs (M + 1, nu) of every run changed."""

        def changed(runs: FreeRuns) -> FreeRuns:
            each = [(u, u.stretch.series) for u in runs.units]
            series = [replace(s, inputs=change(s.inputs)) for _, s in each]
            stretches = [replace(u.stretch, series=s) for (u, _), s in zip(each, series, strict=True)]
            return runs.along([replace(u, stretch=s) for (u, _), s in zip(each, stretches, strict=True)])

        return WholeRecords(changed(self.train), None if self.held_out is None else changed(self.held_out))


def whole_records(model: Model, records: Prepared) -> WholeRecords:
    """The records of a calibration; those of training are cut into pieces where they are few.

    Raises
    ------
    CannotFit : a record lacks what free runs need, or the records are too short to leave a part out.
    """
    bank, length_s = of_numbers(model), time_scale_s(model)
    train = FreeRuns(bank, units_of(model, records.train, length_s, whole=True), length_s, whole=True)
    held_out = [replace(whole_unit(model, r, length_s), number=i) for i, r in enumerate(records.held_out)]
    return WholeRecords(train, FreeRuns(bank, held_out, length_s, whole=True) if held_out else None)


def blind_errors(runs: FreeRuns, values: Mapping[str, float]) -> dict[str, float]:
    """Column -> root mean square error at values of the numbers, without own effects of the records."""
    return root_mean_squares(runs, runs.squares([values] * len(runs.units), runs.no_own))


def root_mean_squares(runs: FreeRuns, squares: np.ndarray) -> dict[str, float]:
    """Column -> root mean square error from sums of squares (K, C)."""
    return dict(zip(runs.channels, np.sqrt(mean_squares(runs, squares)).tolist(), strict=True))


def states_of(runs: FreeRuns, values: np.ndarray) -> np.ndarray:
    """Of values (C,) by channel those of the states."""
    return values[: len(runs.symbols)]


def columns_of_states(runs: FreeRuns) -> Sequence[str]:
    """Columns of the states that count."""
    return runs.channels[: len(runs.symbols)]


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
    by_column = {column: sums.scores()[0] for column, sums in squares_of(runs).items()}
    return {column: (own, by_column.get(column, held)) for column, (own, held) in errors.items()}
