"""What a prediction owes to each of its ingredients, and the error that stays whatever the numbers are.

An ingredient is left out, all numbers are fitted again, and the squared error that comes back is what it removes.  The
floor is the error of held-out records that the model is fitted to themselves: what stays there no change of its numbers
takes off, so that an error at the floor is the structure's.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import replace
from functools import partial
from typing import TYPE_CHECKING

import numpy as np

from ...estimation.diagnosis_only.mixed_effects.fit import fit
from ...estimation.diagnosis_only.mixed_effects.problem import pooled, squares
from .attempts import SHORT, attempt, numbers_of
from .held_out import Errors
from .problems import columns_of, errors_of
from .result import Ingredient

if TYPE_CHECKING:
    from ...estimation.diagnosis_only.mixed_effects.problem import Run
    from ...models.coefficient_groups import Group
    from .attempts import Attempt
    from .problems import Problems

FLOWS = {"measured current": (0, 1), "measured wind": (2, 3)}
"""Columns of each measured flow behind the model's own inputs (`series.with_weather`)."""
VARIES = 0.02
"""Standard deviation of the revolutions, as a share of their size, from which they are an ingredient."""


def ingredients(on: Problems, before: Errors, final: Attempt) -> tuple[Ingredient, ...]:
    """What every measured input, and the numbers that moved, remove of the squared error: that of held-out records,
    of left-out training records where none are held out.

    Eq. 13 of docs/mathematics/calibration.md.

    before : errors of the base model.
    """
    whole = _squared(errors_of(on, final))
    out = []
    for what, changed in _without(on):
        with suppress(np.linalg.LinAlgError):
            trial = attempt(changed.train, final.groups, final.fitted, SHORT)
            out.append(Ingredient(what, _removed(whole, _squared(errors_of(changed, trial)))))
    if final.groups:
        out.append(Ingredient("numbers that moved", _removed(whole, _squared(before))))
    return tuple(out)


def floor(on: Problems, final: Attempt, groups: Sequence[Group]) -> dict[str, float]:
    """Column -> root mean square error of the held-out records by the fit of all numbers, and of every record's own
    neutral rudder angle and start, to these records; nothing where none are held out."""
    p = on.held_out
    if p is None:
        return {}
    theta = final.fitted.theta
    numbers = list({n.name: n for n in numbers_of(p, [*final.groups, *groups])}.values())
    fitted = fit(p, numbers, theta, None, SHORT)
    parts = [squares(p, fitted.theta, run, own) for run, own in zip(p.runs, fitted.own, strict=True)]
    return dict(zip(columns_of(p), pooled(parts).tolist(), strict=True))


def _squared(errors: Errors) -> dict[str, float]:
    return {column: (own if held is None else held) ** 2 for column, (own, held) in errors.items()}


def _removed(whole: Mapping[str, float], without: Mapping[str, float]) -> dict[str, float]:
    return {column: 1.0 - whole[column] / value for column, value in without.items() if value > 0.0}


def _without(on: Problems) -> Iterator[tuple[str, Problems]]:
    """Every measured input that varies, and the records without it."""
    own = len(on.train.model.inputs)
    for what, columns in FLOWS.items():
        places = [own + c for c in columns]
        if any(run.series.inputs.shape[1] > own and np.any(run.series.inputs[:, places]) for run in on.train.runs):
            yield what, on.with_runs(partial(_set, places, lambda values: np.zeros(values.shape[1])))
            yield f"variation of the {what}", on.with_runs(partial(_set, places, lambda values: values.mean(axis=0)))
    if "n" in on.train.model.inputs:
        places = [on.train.model.inputs.index("n")]
        if any(_varies(run.series.inputs[:, places]) for run in on.train.runs):
            yield "variation of the revolutions", on.with_runs(partial(_set, places, lambda values: values[0]))


def _varies(values: np.ndarray) -> bool:
    return bool(np.std(values) > VARIES * np.abs(values).mean())


def _set(places: Sequence[int], to: Callable[[np.ndarray], np.ndarray], run: Run) -> Run:
    """The run with columns of its inputs at a constant."""
    inputs = run.series.inputs.copy()
    if inputs.shape[1] > max(places):
        inputs[:, places] = to(inputs[:, places])
    return replace(run, series=replace(run.series, inputs=inputs))
