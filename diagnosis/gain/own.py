"""A trial's own neutral rudder angle and start: they belong to the trial, not to the model.

Half a degree of neutral angle is ten degrees of heading after a zigzag.  Both are fitted along the record itself, under
the priors that calibrations have (eq. 2 of docs/mathematics/calibration.md without numbers of the model): what
remains is the model's error.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from ...estimation.diagnosis_only.mixed_effects.fit import fit
from ...estimation.diagnosis_only.mixed_effects.problem import problem
from ...models.errors import CannotFit

if TYPE_CHECKING:
    from ...estimation.run.stretch import FreeRun, Stretch


def own_run(stretch: Stretch) -> FreeRun:
    """The free run with the stretch's own neutral rudder angle and start; the plain one of a model without a time to
    scale by."""
    try:
        p = problem(stretch.model, [stretch.record])
    except CannotFit:
        return stretch.free_run()
    angle, *effects = fit(p, (), p.theta).own[0].tolist()
    inputs, start = stretch.series.inputs.copy(), stretch.state_at(0)
    inputs[:, 0] += angle
    for value, symbol in zip(effects, p.states, strict=True):
        start[stretch.model.states.index(symbol)] += value
    return stretch.run(start, inputs)
