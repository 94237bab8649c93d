"""A trial's own neutral rudder angle and start: they belong to the trial, not to the model.

Half a degree of neutral angle is ten degrees of heading after a zigzag.  Both are fitted along the record itself, under
the priors that calibrations have (section 1 of docs/mathematics/calibration.md, without numbers of the model): what
remains is the model's error.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from ...estimation.selection.minimiser import minimise
from ...models.errors import CannotFit
from ...models.time_scale import time_scale_s
from ..free_runs.bank import of_numbers
from ..free_runs.problem import FreeRuns
from ..free_runs.scales import started_states
from ..free_runs.units import whole_unit

if TYPE_CHECKING:
    from ...estimation.run.stretch import FreeRun, Stretch


def own_run(stretch: Stretch) -> FreeRun:
    """The free run with the stretch's own neutral rudder angle and start; the plain one of a model without a time to
    scale by, and of a few samples."""
    try:
        length_s = time_scale_s(stretch.model)
        unit = whole_unit(stretch.model, stretch.record, length_s, stretch.begin_s)
        runs = FreeRuns(of_numbers(stretch.model), [unit], length_s, whole=True)
    except CannotFit:
        return stretch.free_run()
    angle, *effects = minimise(runs, (), {}, runs.no_own).point.own[0].tolist()
    inputs, start = stretch.series.inputs.copy(), stretch.state_at(0)
    inputs[:, 0] += angle
    for value, symbol in zip(effects, started_states(stretch.model), strict=True):
        start[stretch.model.states.index(symbol)] += value
    return stretch.run(start, inputs)
