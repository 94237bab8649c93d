"""A simulation of a craft's particulars, corrected by its records, beside the model that is built from them alone."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

from ...models.errors import CannotFit, FitFailed
from ..calibration.calibrate import calibrate

if TYPE_CHECKING:
    from ...datasets.record import Record
    from ...models.model import Model


def corrected(ship: Model, train: Sequence[Record]) -> tuple[Model, list[str]]:
    """The simulation with the numbers that the training records move under their priors, and what must be known."""
    try:
        found = calibrate(ship, train)
    except (CannotFit, FitFailed) as reason:
        return ship, [f"The simulation of the particulars is as it was given: {reason}."]
    return found.calibrated, []
