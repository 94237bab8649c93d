"""Whether another unit of the rudder explains records better than numbers of the hull do.

Twice or half a rudder angle is nearly a rudder of half or twice the force, and numbers of the hull take it off in part.
So the same selection is made with the other angle, where the yaw motion is followed no worse with it: if it predicts
left-out records better by more than two standard errors, or as well with fewer numbers, none of the hull is told.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING

from ...estimation.mixed_effects.left_out import score_difference
from ...estimation.rudder_scale import of_factor, with_rudder, yaw_error
from .forward import LEAST, Selection

if TYPE_CHECKING:
    from ...checks.result import CheckFinding
    from ...datasets.record import Record
    from ...estimation.mixed_effects.problem import Problem
    from ...models.model import Model

FACTORS = (0.5, 2.0)
"""Factors on the rudder that are tried: the column holds twice, or half, the angle."""
CLEAR = 2.0
"""Standard errors by which the other angle must predict left-out records better."""


def rudder_unit(
    model: Model,
    records: Sequence[Record],
    problem: Problem,
    found: Selection,
    selected: Callable[[Sequence[Record]], Selection],
) -> CheckFinding | None:
    """A finding that stands where another unit of the rudder does better than what was selected; else None.

    problem, found : of the records as they are.  selected : records -> what is selected for them.
    """
    if not found.steps:
        return None
    own = yaw_error(records, model, 1.0)
    for factor in FACTORS:
        if not yaw_error(records, model, factor) < own:
            continue
        other = selected([with_rudder(r, factor) for r in records])
        fall = score_difference(problem, found.final.left_out, other.final.left_out)
        fewer = len(other.final.fitted.numbers) < len(found.final.fitted.numbers)
        least = -LEAST if fewer else max(CLEAR * fall.error, LEAST)
        if fall.gain > least:
            beside = "without any" if not other.steps else f"with {len(other.final.fitted.numbers)}"
            said = (
                f"{factor:g} times the rudder angle predicts left-out records better than numbers of the hull do "
                f"(score lower by {fall.gain:.2f}, standard error {fall.error:.2f}, {beside} of them): the unit or the "
                "scale of the rudder"
            )
            return of_factor(records, factor, said)
    return None
