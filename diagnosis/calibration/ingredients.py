"""What a prediction owes to each of its ingredients, and the error that stays whatever the numbers are.

An ingredient is left out, all numbers are fitted again, and the squared error that comes back is what it removes.  The
floor is the error of held-out records that the model is fitted to themselves: what stays there no change of its numbers
takes off, so that an error at the floor is the structure's.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import suppress
from typing import TYPE_CHECKING

import numpy as np

from .group_fits import SHORT, errors_of, fit_groups
from .result import Ingredient
from .whole_records import Errors, root_mean_squares

if TYPE_CHECKING:
    from ...models.coefficient_groups import Group
    from .group_fits import GroupFit
    from .whole_records import WholeRecords

FLOWS = {"measured current": (0, 1), "measured wind": (2, 3)}
"""Columns of each measured flow behind the model's own inputs (`series.with_weather`)."""
VARIES = 0.02
"""Standard deviation of the revolutions, as a share of their size, from which they are an ingredient."""
Inputs = Callable[[np.ndarray], np.ndarray]


def ingredients(on: WholeRecords, before: Errors, final: GroupFit) -> tuple[Ingredient, ...]:
    """What every measured input, and the numbers that moved, remove of the squared error: that of held-out records,
    of left-out training records where none are held out.

    Eq. 7 of docs/mathematics/calibration.md.

    before : errors of the base model.
    """
    whole = _squared(errors_of(on, final))
    out = []
    for what, change in _without(on):
        changed = on.with_inputs(change)
        with suppress(np.linalg.LinAlgError):
            trial = fit_groups(changed.train, final.groups, final.fitted, steps=SHORT)
            out.append(Ingredient(what, _removed(whole, _squared(errors_of(changed, trial)))))
    if final.groups:
        out.append(Ingredient("numbers that moved", _removed(whole, _squared(before))))
    return tuple(out)


def floor(on: WholeRecords, final: GroupFit, groups: Sequence[Group]) -> dict[str, float]:
    """Column -> root mean square error of the held-out records by the fit of all numbers, and of every record's own
    neutral rudder angle and start, to these records; nothing where none are held out."""
    runs = on.held_out
    if runs is None:
        return {}
    fitted = fit_groups(runs, [*final.groups, *groups], None, final.fitted.point.values, SHORT).fitted
    return root_mean_squares(runs, fitted.point.squares)


def _squared(errors: Errors) -> dict[str, float]:
    return {column: (own if held is None else held) ** 2 for column, (own, held) in errors.items()}


def _removed(whole: Mapping[str, float], without: Mapping[str, float]) -> dict[str, float]:
    return {column: 1.0 - whole[column] / value for column, value in without.items() if value > 0.0}


def _without(on: WholeRecords) -> Iterator[tuple[str, Inputs]]:
    """Every measured input that varies, and what takes it, or its variation, out of the inputs of a run."""
    own, inputs = len(on.train.model.inputs), [unit.stretch.series.inputs for unit in on.train.units]
    for what, columns in FLOWS.items():
        places = [own + c for c in columns]
        if any(u.shape[1] > own and np.any(u[:, places]) for u in inputs):
            yield what, _constant(places, lambda values: np.zeros(values.shape[1]))
            yield f"variation of the {what}", _constant(places, lambda values: values.mean(axis=0))
    if "n" in on.train.model.inputs:
        places = [on.train.model.inputs.index("n")]
        if any(_varies(u[:, places]) for u in inputs):
            yield "variation of the revolutions", _constant(places, lambda values: values[0])


def _varies(values: np.ndarray) -> bool:
    return bool(np.std(values) > VARIES * np.abs(values).mean())


def _constant(places: Sequence[int], to: Callable[[np.ndarray], np.ndarray]) -> Inputs:
    """What puts columns of inputs at a constant."""

    def changed(inputs: np.ndarray) -> np.ndarray:
        out = inputs.copy()
        if inputs.shape[1] > max(places):
            out[:, places] = to(inputs[:, places])
        return out

    return changed
